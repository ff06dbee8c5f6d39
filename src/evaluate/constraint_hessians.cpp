#include <array>
#include <type_traits>

#include "evaluate/constraints.hpp"

namespace tanor {

namespace {

/// Finds the Hessians H of a member's rows from phi, which every kind provides. Along the velocity v
///
///   phi(v) = v'Hv + 2 v'grad(xi_t) + xi_tt,   so   4 a'Hb = phi(a + b) - phi(a - b) - phi(b) + phi(-b)
///
/// phi(v) returns the numbers of the member's rows; `v` [size] is 0 at the beginning. Calls add(i, j, row, a'Hb) for
/// coordinates i <= j.
template <std::size_t Rows, class Phi, class Add>
void find_hessians(std::size_t size, double* v, const Phi& phi, const Add& add) {
  std::vector<std::array<double, Rows>> odd(size);  // phi(b) - phi(-b)
  for (std::size_t j = 0; j < size; ++j) {
    v[j] = 1.0;
    const auto forwards = phi(v);
    v[j] = -1.0;
    const auto backwards = phi(v);
    v[j] = 0.0;
    for (std::size_t m = 0; m < Rows; ++m) odd[j][m] = forwards[m] - backwards[m];
  }
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t j = i; j < size; ++j) {
      v[i] += 1.0;
      v[j] += 1.0;
      const auto sum = phi(v);
      v[j] -= 2.0;
      const auto difference = phi(v);
      v[i] = v[j] = 0.0;
      for (std::size_t m = 0; m < Rows; ++m) add(i, j, m, 0.25 * (sum[m] - difference[m] - odd[j][m]));
    }
  }
}

template <class Append>
void list_members(const LinearFamily&, const Append&) {}

template <class Append>
void list_members(const UserFamily& family, const Append& append) {
  for (const UserGroup& group : family.kernel.groups) {
    const std::size_t p = group.points_per_member();
    for (std::size_t k = 0; k < group.size(); ++k) append(std::span(group.points).subspan(k * p, p));
  }
}

template <class Kernel, class Append>
void list_members(const Family<Kernel>& family, const Append& append) {
  if constexpr (!is_rod_kernel<Kernel>) {
    for (const auto& points : family.kernel.points) append(std::span<const Index>(points));
  }
}

/// Adds `value`, which is -lambda times the entry (i, j) of a Hessian, to the blocks [p][p] of a member.
void add_entry(std::size_t p, std::size_t i, std::size_t j, double value, Block3* blocks) {
  blocks[i / 3 * p + j / 3].entries[3 * (i % 3) + j % 3] += value;
  if (i != j) blocks[j / 3 * p + i / 3].entries[3 * (j % 3) + i % 3] += value;
}

Block3* evaluate_members(const LinearFamily&, const double*, const double*, double*, Block3* to) {
  return to;
}

Block3* evaluate_members(const UserFamily& family, const double* r, const double* lambda, double*, Block3* to) {
  for (const UserGroup& group : family.kernel.groups) {
    const std::size_t p = group.points_per_member(), size = 3 * p;
    std::vector<double> places(size), velocities(size, 0.0);
    for (std::size_t k = 0; k < group.size(); ++k, to += p * p) {
      const double multiplier = lambda[group.rows[k]];
      std::fill(to, to + p * p, Block3{});
      for (std::size_t i = 0; i < p; ++i) store(places.data(), i, load(r, group.points[k * p + i]));
      const auto phi = [&](const double* v) {
        double xi = 0.0, rate = 0.0, second = 0.0;
        group.kernel.evaluate(group.kernel.context.get(),
                              {1, family.kernel.t, places.data(), v, &xi, &rate, &second, nullptr});
        return std::array{second};
      };
      if (multiplier == 0.0) continue;
      find_hessians<1>(size, velocities.data(), phi, [&](std::size_t i, std::size_t j, std::size_t, double entry) {
        add_entry(p, i, j, -multiplier * entry, to);
      });
    }
  }
  return to;
}

template <class Kernel>
Block3* evaluate_members(const Family<Kernel>& family, const double* r, const double* lambda, double* v, Block3* to) {
  if constexpr (!is_rod_kernel<Kernel>) {
    constexpr std::size_t p = Kernel::num_points, rows = Kernel::num_rows;
    std::array<double, 3 * p> move{};
    for (std::size_t k = 0; k < family.size(); ++k, to += p * p) {
      const double* const multipliers = lambda + family.rows[k];
      const auto& points = family.kernel.points[k];
      std::fill(to, to + p * p, Block3{});
      const auto phi = [&](const double* own) {
        for (std::size_t i = 0; i < p; ++i) store(v, points[i], load(own, i));
        const auto local = family.kernel(k, r, v);
        std::array<double, rows> result;
        for (std::size_t m = 0; m < rows; ++m) result[m] = local.phi[m];
        return result;
      };
      find_hessians<rows>(3 * p, move.data(), phi, [&](std::size_t i, std::size_t j, std::size_t m, double entry) {
        add_entry(p, i, j, -multipliers[m] * entry, to);
      });
      for (const Index point : points) store(v, point, Vec3{});
    }
  }
  return to;
}

}  // namespace

std::vector<Influence> Constraints::list_curved() const {
  std::vector<Influence> result;
  for_each_family([&](const auto& family) {
    list_members(family, [&](std::span<const Index> points) {
      for (const Index on : points) {
        for (const Index of : points) result.push_back({on, of});
      }
    });
  });
  return result;
}

void Constraints::evaluate_curvatures(const double* r, const double* lambda, Block3* to) const {
  std::vector<double> velocities(3 * num_points_, 0.0);
  for_each_family([&](const auto& family) { to = evaluate_members(family, r, lambda, velocities.data(), to); });
}

}  // namespace tanor
