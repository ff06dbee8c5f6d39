#pragma once

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include <tanor/kinds/constraint/linear.hpp>

#include "base/vec3.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is the sum over the tuple of c.r, minus the value. Gradients are constant.
struct LinearKernel {
  using Group = Linears;

  std::vector<Index> start{0};     ///< [member] first of its points
  std::vector<Index> points;       ///< tuples one after the other
  std::vector<Vec3> coefficients;  ///< beside `points`
  std::vector<double> norms;       ///< [member] largest |c| of its tuple
  ScalarTable value;               ///< [member]
  std::vector<double> size;        ///< [member] m, of the neighbourhood

  void set_time(double t) { value.set_time(t); }
  bool depends_on_time() const { return !value.is_constant(); }
  bool gradients_are_constant() const { return true; }
  double scale(std::size_t k) const { return size[k]; }

  void add_member(const Linears& linears, std::span<const Index> inner_points) {
    double norm2 = 0.0;
    for (std::size_t p = 0; p < inner_points.size(); ++p) {
      const Vec3 c = make_vec3(linears.coefficients[p]);
      points.push_back(inner_points[p]);
      coefficients.push_back(c);
      norm2 = std::max(norm2, dot(c, c));
    }
    start.push_back(static_cast<Index>(points.size()));
    norms.push_back(std::sqrt(norm2));
  }

  /// Returns the row of K'x of member k.
  double transposed(std::size_t k, const double* x) const {
    double sum = 0.0;
    for (Index i = start[k]; i < start[k + 1]; ++i) sum += dot(coefficients[i], load(x, points[i]));
    return sum;
  }
};

}  // namespace tanor::detail
