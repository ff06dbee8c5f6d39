#pragma once

#include <vector>

#include "dynamics/linearization.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// The rank of K: what is told about it, and how near K came to losing it between two configurations.
class GradientRank final : public RankMonitor {
 public:
  GradientRank(Workspace& work, Linearization& linearization)
      : work_(work), model_(work.model()), linearization_(linearization) {}

  /// Rank of K at the last linearisation, at r: as it was decided where S raised a suspicion, else d. `thoroughly`:
  /// decides now.
  RankReport report(const double* r, bool thoroughly);
  /// What depends, as it was decided, and nothing of the report that has a cost of its own.
  std::vector<RowDependence> list_dependences() const;
  /// Puts into words what another decision at the same configuration found.
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
  std::vector<double> before_;        // K that is remembered; empty: none, or rows depended
  std::vector<double> x_, y_, move_;  // [d], [d], [3n] scratch
};

}  // namespace tanor
