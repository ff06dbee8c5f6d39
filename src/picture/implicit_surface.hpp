#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <tanor/expression.hpp>

#include "base/vec3.hpp"

namespace tanor::picture {

/// xi(x, y, z) at one time, from the numbers of a guide of kind "formula" (report/guides.hpp).
class ImplicitFunction {
 public:
  /// None where the numbers are no list of operations.
  static std::optional<ImplicitFunction> read(std::span<const double> numbers);

  double operator()(Vec3 place);

 private:
  bool append(std::span<const double> row);

  std::vector<Expression::Instruction> steps_;
  std::size_t result_ = 0;
  double t_ = 0.0;
  std::vector<double> values_;  // of the steps, at the place at hand
};

/// A triangle of a surface; an edge that runs along a line of its net is drawn.
struct SurfacePart {
  std::array<Vec3, 3> corners;
  std::array<bool, 3> is_line;  ///< from each corner to the next
};

/// The surface xi = 0 in a cube, by marching tetrahedra.
std::vector<SurfacePart> polygonise(ImplicitFunction xi, Vec3 middle, double half_side);

}  // namespace tanor::picture
