#pragma once

#include <vector>

#include "dynamics/linearization.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Reports the rank of K, and how near K came to losing rank between two configurations. Nothing is known of the latter
/// where a team has parts of K.
class GradientRank final : public RankMonitor {
 public:
  GradientRank(Workspace& work, Linearization& linearization)
      : work_(work), model_(work.model()), linearization_(linearization) {}

  /// Returns the rank of K at the last linearisation, at r. It is that of the last decision if S raised a suspicion,
  /// otherwise d. If `thoroughly` is true, the rank is decided now.
  RankReport report(const double* r, bool thoroughly);
  /// Lists the dependences of the last decision, without those parts of the report that cost time.
  std::vector<RowDependence> list_dependences() const;
  /// Describes the result of another decision at the same configuration.
  RankReport describe(const Redundancy& redundancy) const;

  double mass_ratio() const override { return model_.mass_ratio; }
  void remember_gradients() override;
  double compare_gradients() override;

 private:
  std::size_t user_row(std::size_t row) const;
  bool depends_on_contacts(const Redundancy::Found& found) const;
  std::vector<RowDependence> list_dependences(const Redundancy& redundancy) const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  std::vector<double> before_;        // the K that is remembered; empty if there is none, or rows depended
  std::vector<double> x_, y_, move_;  // [d], [d], [3n] scratch
};

}  // namespace tanor::detail
