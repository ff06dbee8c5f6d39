#pragma once

#include <array>
#include <string>
#include <vector>

#include "base/vec3.hpp"
#include "dynamics/model.hpp"

namespace tanor::detail {

/// Vectors along which constraints need a direction though their lengths may change: the parts of ropes, from a wheel
/// to its point, the legs of angles, and rods whose lengths depend on time. Where one is 0, the constraint has no
/// gradient.
class ConstraintArms {
 public:
  explicit ConstraintArms(const Model& model);

  std::size_t size() const { return arms_.size(); }
  /// Writes the vectors [size()], m, for inner positions r [3n].
  void evaluate(const double* r, Vec3* vectors) const;
  /// Returns how far the ends of arm k are from the origin together, m.
  double size(const double* r, std::size_t k) const;
  /// Returns the length that arm k is given at t, m; infinity if nothing gives it one.
  double given_length(double t, std::size_t k) const;
  /// Returns "rope[0]: the part from b to point 1".
  std::string name(std::size_t k) const;

 private:
  struct Arm {
    std::size_t group, member;  // of the system's constraints
    Index begin, end;           // inner points; the beginning of a part of a rope is its wheel, -1 at a and -2 at b
    Vec3 shift;                 // of the beginning from its point, or from the origin
    ScalarFunction length{};    // of a rod
  };
  static Vec3 begin(const double* r, const Arm& arm);

  const Model& model_;
  std::vector<Arm> arms_;
};

}  // namespace tanor::detail
