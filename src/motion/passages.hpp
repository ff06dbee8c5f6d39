#pragma once

#include <vector>

#include "base/point_path.hpp"
#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor {

/// Looks along a step that was made for forces which act between the looks of its scheme alone: a pair that meets and
/// parts there, a narrow well that is jumped. An error estimate, which is made of the looks, knows nothing of them.
class Passages final : private PointPath {
 public:
  Passages(const IntegrationOptions& options, Mechanics& mechanics, bool follows_tolerance);

  /// The part of the step to make instead; 1: it passes nothing unseen. The mechanics stays where it is, and what is
  /// found depends on the two states and on the scheme alone.
  double look(Scheme& scheme, const State& from, const State& to);

 private:
  void refine(double error) override;
  void weigh_looks();
  void set_knots(std::size_t pieces);
  double measure_bend() const;

  Mechanics& mechanics_;
  ForcePassages* const forces_;  // null: no force acts between the looks alone
  // Of the step that is looked at.
  Scheme* scheme_ = nullptr;
  const State *from_ = nullptr, *to_ = nullptr;
  double bend_ = 0.0;
  std::vector<double> looks_, weights_;
  // Workspaces, [knot].
  std::vector<std::vector<double>> positions_, velocities_, variables_, rates_;
};

}  // namespace tanor
