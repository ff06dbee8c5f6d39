#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <type_traits>

#include "evaluate/constraints.hpp"

namespace tanor::detail {

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

/// Finds the products Hy of a member's rows likewise, with y at moves + m * size for row m, from the unit vectors e_i
/// and y scaled to 1. `v` [size] is scratch. Calls add(i, sum of (Hy)_i over the rows) for all coordinates.
template <std::size_t Rows, class Phi, class Add>
void find_products(std::size_t size, const double* moves, double* v, const Phi& phi, const Add& add) {
  for (std::size_t m = 0; m < Rows; ++m, moves += size) {
    double scale = 0.0;
    for (std::size_t k = 0; k < size; ++k) scale = larger(scale, std::abs(moves[k]));
    if (scale == 0.0) continue;
    const auto phi_along = [&](double sign, std::size_t i) {
      for (std::size_t k = 0; k < size; ++k) v[k] = (k == i ? 1.0 : 0.0) + sign * moves[k] / scale;
      return phi(v)[m];
    };
    const double odd = phi_along(1.0, size) - phi_along(-1.0, size);  // of y alone
    for (std::size_t i = 0; i < size; ++i) add(i, 0.25 * scale * (phi_along(1.0, i) - phi_along(-1.0, i) - odd));
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

// These call body(member, phi) for all members of a family but rods and linear ones, whose Hessians are simpler.

/// A member of a family, with its first row and its first block of K.
struct CurvedMember {
  std::span<const Index> points;
  std::size_t row, block;
};

template <class Body>
void visit_curved(const LinearFamily&, const double*, double*, const Body&) {}

template <class Body>
void visit_curved(const UserFamily& family, const double* r, double*, const Body& body) {
  for (const UserGroup& group : family.kernel.groups) {
    const std::size_t p = group.points_per_member();
    std::vector<double> places(3 * p);
    const auto phi = [&](const double* v) {
      double xi = 0.0, rate = 0.0, second = 0.0;
      group.kernel.evaluate(group.kernel.context.get(),
                            {1, family.kernel.t, places.data(), v, &xi, &rate, &second, nullptr});
      return std::array{second};
    };
    const auto first_block = static_cast<std::size_t>(family.first_block + group.first_block);
    for (std::size_t k = 0; k < group.size(); ++k) {
      const std::span<const Index> points = std::span(group.points).subspan(k * p, p);
      for (std::size_t i = 0; i < p; ++i) store(places.data(), i, load(r, points[i]));
      body(CurvedMember{points, static_cast<std::size_t>(group.rows[k]), first_block + k * p}, phi);
    }
  }
}

/// `velocities` [3n] is scratch.
template <class Kernel, class Body>
void visit_curved(const Family<Kernel>& family, const double* r, double* velocities, const Body& body) {
  if constexpr (!is_rod_kernel<Kernel>) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      const auto& points = family.kernel.points[k];
      const auto phi = [&](const double* v) {
        for (std::size_t i = 0; i < points.size(); ++i) store(velocities, points[i], load(v, i));
        return std::to_array(family.kernel(k, r, velocities).phi);
      };
      body(CurvedMember{points, static_cast<std::size_t>(family.rows[k]),
                        static_cast<std::size_t>(family.first_block) + k * Kernel::num_blocks},
           phi);
    }
  }
}

/// Adds (I - uu')y/L at the second point of each rod, and subtracts it at the first one.
template <class F>
void add_rod_products(const F& family, const double* r, const double* moves, double* to) {
  if constexpr (is_rod_kernel<decltype(F::kernel)>) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      const Vec3 y = load(moves, static_cast<std::size_t>(family.first_block) + k);
      if (dot(y, y) == 0.0) continue;
      const auto [i, j] = family.kernel.points[k];
      Vec3 a = load(r, j) - load(r, i);
      if (!family.kernel.offset.empty()) a = a + family.kernel.offset[k];
      const double inverse_length = 1.0 / norm(a);
      const Vec3 u = inverse_length * a, product = inverse_length * (y - dot(u, y) * u);
      add_to(to, j, product);
      add_to(to, i, -product);
    }
  }
}

template <class Phi>
constexpr std::size_t num_rows_of = std::tuple_size_v<std::invoke_result_t<Phi, const double*>>;

/// Adds `value`, which is -lambda times the entry (i, j) of a Hessian, to the blocks [p][p] of a member.
void add_entry(std::size_t p, std::size_t i, std::size_t j, double value, Block3* blocks) {
  blocks[i / 3 * p + j / 3].entries[3 * (i % 3) + j % 3] += value;
  if (i != j) blocks[j / 3 * p + i / 3].entries[3 * (j % 3) + i % 3] += value;
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
  std::vector<double> velocities(3 * num_points_), own;
  const auto evaluate = [&]<class Phi>(const CurvedMember& member, const Phi& phi) {
    constexpr std::size_t num_rows = num_rows_of<Phi>;
    const std::size_t p = member.points.size();
    const std::span multipliers(lambda + member.row, num_rows);
    std::fill(to, to + p * p, Block3{});
    if (std::ranges::any_of(multipliers, [](double multiplier) { return multiplier != 0.0; })) {
      own.assign(3 * p, 0.0);
      find_hessians<num_rows>(3 * p, own.data(), phi, [&](std::size_t i, std::size_t j, std::size_t m, double entry) {
        add_entry(p, i, j, -multipliers[m] * entry, to);
      });
    }
    to += p * p;
  };
  for_each_family([&](const auto& family) { visit_curved(family, r, velocities.data(), evaluate); });
}

void Constraints::add_hessian_products(const double* r, const double* moves, double* to) const {
  std::vector<double> velocities(3 * num_points_), own;
  const auto add = [&]<class Phi>(const CurvedMember& member, const Phi& phi) {
    const std::size_t size = 3 * member.points.size();
    own.resize(size);
    find_products<num_rows_of<Phi>>(size, moves + 3 * member.block, own.data(), phi,
                                    [&](std::size_t i, double product) {
                                      to[3 * static_cast<std::size_t>(member.points[i / 3]) + i % 3] += product;
                                    });
  };
  for_each_family([&](const auto& family) {
    visit_curved(family, r, velocities.data(), add);
    add_rod_products(family, r, moves, to);
  });
}

}  // namespace tanor::detail
