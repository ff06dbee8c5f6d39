#pragma once

#include <vector>

#include "dynamics/linearization.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Tells how near K came to losing rank between two configurations. Nothing is known where a team has parts of K.
class GradientRank final : public RankMonitor {
 public:
  GradientRank(Workspace& work, Linearization& linearization)
      : work_(work), model_(work.model()), linearization_(linearization) {}

  double mass_ratio() const override { return model_.mass_ratio; }
  void remember_gradients() override;
  double compare_gradients() override;

 private:
  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  std::vector<double> before_;        // the K that is remembered; empty if there is none, or rows depended
  std::size_t openings_ = 0;          // of one-sided rows, where it was
  std::vector<double> x_, y_, move_;  // [d], [d], [3n] scratch
};

}  // namespace tanor::detail
