#pragma once

#include <array>
#include <vector>

#include <tanor/kinds/constraint/rod.hpp>

#include "kinds/kernel.hpp"
#include "kinds/tables.hpp"

namespace tanor::detail {

/// xi is |r_j - r_i + offset| - length. `Timed` says that lengths move, `Shifted` that some offset is not zero.
template <bool Timed, bool Shifted>
struct RodKernel {
  static constexpr int num_points = 2, num_rows = 1, num_blocks = 1;
  static constexpr bool unit_gradient = true;
  using Group = Rods;

  std::vector<std::array<Index, 2>> points;
  std::vector<double> length;  // empty if Timed
  ScalarTable moving_length;   // Timed only
  std::vector<Vec3> offset;    // Shifted only

  /// Returns true if this one of the four kernels of rods serves the group.
  static bool takes(const Rods& rods) {
    return rods.length.functions.empty() != Timed && rods.offsets.empty() != Shifted;
  }
  void add_member(const Rods& rods, Index k) {
    if constexpr (Shifted) offset.push_back(make_vec3(rods.offsets[static_cast<std::size_t>(k)]));
  }
  ScalarTable& own() requires Timed { return moving_length; }
  std::vector<double>& own_constants() requires(!Timed) { return length; }

  void set_time(double t) { moving_length.set_time(t); }
  bool depends_on_time() const { return Timed; }
  bool gradients_are_constant() const { return false; }
  double scale(std::size_t k) const {
    if constexpr (Timed) return moving_length[k].value;
    return length[k];
  }

  [[gnu::always_inline]] Local<1, 1> operator()(std::size_t k, const double* r, const double* v) const {
    const auto [i, j] = points[k];
    Vec3 a = load(r, j) - load(r, i);
    if constexpr (Shifted) a = a + offset[k];
    const Distance rho(a, load(v, j) - load(v, i));
    Local<1, 1> local{{}, {rho.first}, {rho.second}, {rho.unit}};
    if constexpr (Timed) {
      const MovingScalar& l = moving_length[k];
      local.xi[0] = rho.value - l.value;
      local.rate[0] -= l.first;
      local.phi[0] -= l.second;
    } else {
      local.xi[0] = rho.value - length[k];
    }
    return local;
  }
};

/// True for the four kernels of rods.
template <class Kernel>
inline constexpr bool is_rod_kernel = false;
template <bool Timed, bool Shifted>
inline constexpr bool is_rod_kernel<RodKernel<Timed, Shifted>> = true;

}  // namespace tanor::detail
