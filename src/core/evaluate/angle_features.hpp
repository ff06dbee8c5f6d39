#pragma once

#include <array>
#include <vector>

#include <tanor/system.hpp>

#include "base/parallel.hpp"
#include "base/point_path.hpp"

namespace tanor::detail {

/// Finds steps that pass an angle of three points at which a law is not smooth. Where the points are in line, dihedral
/// angles are undefined and harmonic bendings have a tip. Only that instant itself shows it, so a step may pass from
/// one side to the other unseen.
///
/// With a and b from the corner to the other two, the sine |a x b|/(|a||b|) falls and rises again in such a step. How
/// far it falls is the scale on which forces change there. A step over a deep fall is shortened, and each next one
/// comes nearer, until the points have passed each other or are in line.
class AngleFeatures {
 public:
  enum class Ends { AtZero, AtZeroAndStraight };
  /// Adds an angle. `triple` has inner points, with the corner in the middle.
  void append(const std::array<Index, 3>& triple, Ends ends);
  /// Removes duplicates after the last `append`.
  void finish();

  bool empty() const { return triples_.empty(); }
  /// Returns the part of the step to make instead, or 1 if no sine falls far in it.
  double find(const Parallel& parallel, PointPath* path);

 private:
  struct Triple {
    std::array<Index, 3> points;
    Ends ends;
    auto operator<=>(const Triple&) const = default;
  };
  struct Fall {
    double part = 1.0;   // fraction of the step at which the sine is least
    double depth = 1.0;  // least sine over the smaller one of those at both ends
  };
  static bool may_fall(const PointPath& path, const Triple& triple);
  static Fall find_least(const PointPath& path, const Triple& triple);

  std::vector<Triple> triples_;
  std::vector<char> is_doubtful_;  // [triple]
};

}  // namespace tanor::detail
