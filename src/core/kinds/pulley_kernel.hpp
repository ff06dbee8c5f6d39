#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <tanor/kinds/constraint/pulley.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is |r_i - a| + ratio |r_j - b| - length.
struct PulleyKernel {
  static constexpr int num_points = 2, num_rows = 1, num_blocks = 2;
  static constexpr bool unit_gradient = false;
  using Group = Pulleys;

  struct Wheel {
    Vec3 a, b;
    double ratio;
  };
  std::vector<std::array<Index, 2>> points;
  std::vector<Index> geometry;
  std::vector<Wheel> wheels;
  ScalarTable length;        // one a member; may be 0 or negative where the ratio is
  std::vector<double> size;  // m, of the neighbourhood, one a member

  void add(const Pulleys& pulleys) { wheels.push_back({make_vec3(pulleys.a), make_vec3(pulleys.b), pulleys.ratio}); }
  ScalarTable& own() { return length; }
  /// Returns |gradient|^2 at the first or second point, which never changes.
  double squared_norm(std::size_t k, std::size_t p) const {
    const double ratio = wheels[static_cast<std::size_t>(geometry[k])].ratio;
    return p == 0 ? 1.0 : ratio * ratio;
  }

  void set_time(double t) { length.set_time(t); }
  bool depends_on_time() const { return !length.is_constant(); }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const { return size[k]; }

  [[gnu::always_inline]] Local<1, 2> operator()(std::size_t k, const double* r, const double* v) const {
    const auto [i, j] = points[k];
    const auto& [a, b, ratio] = wheels[geometry[k]];
    const MovingScalar& l = length[k];
    const Distance first(load(r, i) - a, load(v, i)), second(load(r, j) - b, load(v, j));
    Local<1, 2> local{{first.value + ratio * second.value - l.value},
                      {first.first + ratio * second.first - l.first},
                      {first.second + ratio * second.second - l.second},
                      {first.unit, ratio * second.unit}};
    local.gradient_norm[0] = std::max(1.0, std::abs(ratio));
    return local;
  }
};

}  // namespace tanor::detail
