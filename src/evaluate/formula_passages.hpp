#pragma once

#include <array>
#include <optional>
#include <vector>

#include <tanor/kernel.hpp>
#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "base/point_path.hpp"
#include "evaluate/narrowness.hpp"

namespace tanor {

/// What one formula does to its points while a step passes: a well, a wall or a window that is narrow beside the step
/// may lie between the looks of its scheme.
///
/// Intervals that hold the path tell how often the formula may change its course on the way (`Narrowness`). A few times
/// is what every scheme resolves, or its error estimate sees that it does not. Where it may be more, the path is halved
/// until it is a few times in each part, the formula is evaluated in all of them, and what is found is compared with a
/// polynomial over the whole step, which is how a scheme sees the force.
class FormulaPassages {
 public:
  /// `kernel` has an expression of x, y, z, vx, vy, vz and t.
  FormulaPassages(const ForceKernel& kernel, std::vector<Index> points);

  /// False: sums and products alone.
  bool is_needed() const { return narrowness_.is_possible(); }
  /// The part of the step to make instead; 1: nothing is hidden in it. `masses` [moving point], kg.
  double find(const Parallel& parallel, PointPath* path, std::span<const double> masses);

 private:
  /// A part of a step in which the formula changes its course a few times at most, or that is as short as parts may be.
  struct Part {
    double begin, end;  // fractions of the step
  };
  using Counts = std::array<double, num_lanes>;
  bool is_doubtful(const PointPath& path, Index point) const;
  Counts count_along(const PointPath& path, std::span<const Index> points) const;
  Counts count_parts(const PointPath& path, Index point, double begin, double end) const;
  double divide(const PointPath& path, Index point, double begin, double end, int depth,
                std::vector<Part>* parts) const;
  double examine(const PointPath& path, Index point, double mass) const;
  Vec3 acceleration(const PointPath& path, Index point, double s, double mass) const;

  Narrowness narrowness_;
  bool asks_for_rates_;
  std::vector<Index> points_;      // inner ones that move
  std::vector<char> is_doubtful_;  // [point]
};

}  // namespace tanor
