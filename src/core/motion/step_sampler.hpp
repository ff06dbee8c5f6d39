#pragma once

#include <vector>

#include "base/point_path.hpp"
#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Looks along a step for forces that act only between the looks of its scheme, as of a pair that meets and parts there
/// or a narrow well that is jumped. An error estimate is made of the looks and cannot see such forces.
class StepSampler final : private PointPath {
 public:
  StepSampler(const IntegrationOptions& options, Mechanics& mechanics, const Scheme& scheme);

  /// Returns the part of the step to make instead; 1 if the step passes nothing unseen. The mechanics is not moved, and
  /// the result depends only on the two states and on the scheme, or on the states alone if `by_ends` is true.
  double look(Scheme& scheme, const State& from, const State& to, bool by_ends = false);
  /// Looks for jumps alone, along the parabola on which the motion leaves `from`. Where a step has failed at a jump its
  /// own end and what it knows of its inside are made of forces on both sides, and may show no jump at all.
  void look_along_parabola(Scheme& scheme, const State& from, double t);
  /// Returns true if forces may jump where points reach certain places.
  bool may_find_jumps() const { return may_jump_; }
  /// Returns where on the last step a force jumps first.
  const Jump& found_jump() const { return jump; }
  /// Names what the last step passes unseen.
  std::string name_passed() const { return passed != nullptr ? *passed : "a force"; }

 private:
  /// A part of the step.
  struct Part final : PointPath {
    void refine(double) override {}
  };
  /// The numbers of a path at its knots, [knot][number].
  struct Knots {
    std::vector<std::vector<double>> positions, velocities, variables, rates;
  };

  const PointPath* magnify(double begin, double end) override;
  void refine(double error) override;
  void weigh_looks();
  void set_knots(double begin, double end, std::size_t pieces, Knots* room, PointPath* path);
  double measure_bend() const;

  Mechanics& mechanics_;
  UnseenForces* const forces_;  // null if no force acts only between the looks
  // The step that is examined.
  Scheme* scheme_ = nullptr;
  const State *from_ = nullptr, *to_ = nullptr;
  bool by_ends_ = false;  // true if the step is interpolated from its ends
  State ahead_;           // end of a parabola
  double bend_ = 0.0;
  std::vector<double> looks_, weights_;
  const bool may_jump_;
  Part part_;
  Knots knots_, knots_of_part_;
};

}  // namespace tanor::detail
