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

/// A member of a family, with its first row and its first block of K.
struct CurvedMember {
  std::span<const Index> points;
  std::size_t row, block;
};

// These call visit(member, phi) for all members of a family but rods and linear ones, whose Hessians are simpler.
// phi(r, room, v) returns phi of the member's rows at r [3n] and the velocities v of its points; `room` [3n] is
// scratch.

template <class Visit>
void visit_curved(const TupleFamily<LinearKernel>&, const Visit&) {}

template <class Visit>
void visit_curved(const TupleFamily<RopeKernel>& family, const Visit& visit) {
  for (std::size_t k = 0; k < family.size(); ++k) {
    const std::span<const Index> points = family.kernel.tuple(k);
    const auto phi = [&](const double* r, double* room, const double* v) {
      for (std::size_t i = 0; i < points.size(); ++i) store(room, points[i], load(v, i));
      return std::array{family.kernel.row(k, r, room).phi()};
    };
    visit(CurvedMember{points, static_cast<std::size_t>(family.rows[k]), family.block(k)}, phi);
  }
}

template <class Visit>
void visit_curved(const TupleFamily<UserKernels>& family, const Visit& visit) {
  for (const UserGroup& group : family.kernel.groups) {
    for (std::size_t k = group.first; k < group.last; ++k) {
      const std::span<const Index> points = family.kernel.tuple(k);
      const auto phi = [&](const double* r, double* room, const double* v) {
        for (std::size_t i = 0; i < points.size(); ++i) store(room, i, load(r, points[i]));
        double xi = 0.0, rate = 0.0, second = 0.0;
        group.kernel.evaluate(group.kernel.context.get(), {1, family.kernel.t, room, v, &xi, &rate, &second, nullptr});
        return std::array{second};
      };
      visit(CurvedMember{points, static_cast<std::size_t>(family.rows[k]), family.block(k)}, phi);
    }
  }
}

template <class Kernel, class Visit>
void visit_curved(const Family<Kernel>& family, const Visit& visit) {
  if constexpr (!is_rod_kernel<Kernel>) {
    for (std::size_t k = 0; k < family.size(); ++k) {
      const auto& points = family.kernel.points[k];
      const auto phi = [&](const double* r, double* room, const double* v) {
        for (std::size_t i = 0; i < points.size(); ++i) store(room, points[i], load(v, i));
        return std::to_array(family.kernel(k, r, room).phi);
      };
      visit(CurvedMember{points, static_cast<std::size_t>(family.rows[k]),
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

template <class F>
constexpr bool is_rods = is_rod_kernel<std::remove_cvref_t<decltype(std::declval<F>().kernel)>>;

template <class Phi>
constexpr std::size_t num_rows_of = std::tuple_size_v<std::invoke_result_t<Phi, const double*, double*, const double*>>;

/// Adds `value`, which is -lambda times the entry (i, j) of a Hessian, to the blocks [p][p] of a member.
void add_entry(std::size_t p, std::size_t i, std::size_t j, double value, Block3* blocks) {
  blocks[i / 3 * p + j / 3].entries[3 * (i % 3) + j % 3] += value;
  if (i != j) blocks[j / 3 * p + i / 3].entries[3 * (j % 3) + i % 3] += value;
}

}  // namespace

std::vector<Influence> Constraints::list_curved() const {
  std::vector<Influence> result;
  for_each_family([&](const auto& family) {
    visit_curved(family, [&](const CurvedMember& member, const auto&) {
      for (const Index on : member.points) {
        for (const Index of : member.points) result.push_back({on, of});
      }
    });
  });
  return result;
}

void Constraints::evaluate_curvatures(const double* r, const double* lambda, Block3* to) const {
  std::vector<double> room(3 * num_points_), own;
  const auto evaluate = [&]<class Phi>(const CurvedMember& member, const Phi& phi) {
    constexpr std::size_t num_rows = num_rows_of<Phi>;
    const std::size_t p = member.points.size();
    const std::span multipliers(lambda + member.row, num_rows);
    std::fill(to, to + p * p, Block3{});
    if (std::ranges::any_of(multipliers, [](double multiplier) { return multiplier != 0.0; })) {
      own.assign(3 * p, 0.0);
      find_hessians<num_rows>(
          3 * p, own.data(), [&](const double* v) { return phi(r, room.data(), v); },
          [&](std::size_t i, std::size_t j, std::size_t m, double entry) {
            add_entry(p, i, j, -multipliers[m] * entry, to);
          });
    }
    to += p * p;
  };
  for_each_family([&](const auto& family) { visit_curved(family, evaluate); });
}

void Constraints::add_hessian_products(const double* r, const double* moves, double* to) const {
  std::vector<double> room(3 * num_points_), own;
  const auto add = [&]<class Phi>(const CurvedMember& member, const Phi& phi) {
    const std::size_t size = 3 * member.points.size();
    own.resize(size);
    find_products<num_rows_of<Phi>>(
        size, moves + 3 * member.block, own.data(), [&](const double* v) { return phi(r, room.data(), v); },
        [&](std::size_t i, double product) {
          to[3 * static_cast<std::size_t>(member.points[i / 3]) + i % 3] += product;
        });
  };
  for_each_family([&](const auto& family) {
    visit_curved(family, add);
    add_rod_products(family, r, moves, to);
  });
}

std::vector<Coupling> Constraints::list_rods() const {
  std::vector<Coupling> result;
  for_each_family([&](const auto& family) {
    if constexpr (is_rods<decltype(family)>) {
      for (const auto& [i, j] : family.kernel.points) result.push_back({i, j});
    }
  });
  return result;
}

void Constraints::evaluate_rod_derivatives(const Parallel& parallel, const double* r, const double* lambda,
                                           Block3* to) const {
  for_each_family([&](const auto& family) {
    if constexpr (is_rods<decltype(family)>) {
      parallel.for_ranges(family.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
          const auto local = family.kernel(k, r, r);
          const double length = local.xi[0] + family.kernel.scale(k);
          const double tension = -lambda[family.rows[k]];
          Block3 block;
          block.add_identity(-tension / length);
          block.add_product(tension / length, local.gradient[0], local.gradient[0]);
          to[k] = block;
        }
      });
      to += family.size();
    }
  });
}

}  // namespace tanor::detail
