#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <tanor/expression.hpp>

#include "base/vec3.hpp"

namespace tanor::picture {
using namespace detail;

/// The function xi(x, y, z) at one time, made from the numbers of a guide of kind "formula" (report/guides.hpp).
class ImplicitFunction {
 public:
  /// Returns nothing if the numbers do not describe a list of operations.
  static std::optional<ImplicitFunction> read(std::span<const double> numbers);

  double operator()(Vec3 place);

 private:
  bool append(std::span<const double> row);

  std::vector<Expression::Instruction> steps_;
  std::size_t result_ = 0;
  double t_ = 0.0;
  std::vector<double> values_;  // of the steps, at the current position
};

/// A triangle of a surface; its edges along lines of the net are drawn.
struct SurfacePart {
  std::array<Vec3, 3> corners;
  std::array<bool, 3> is_line;  ///< from each corner to the next
};

/// Returns the surface xi = 0 in a cube, found by marching tetrahedra.
std::vector<SurfacePart> polygonise(ImplicitFunction xi, Vec3 middle, double half_side);

}  // namespace tanor::picture
