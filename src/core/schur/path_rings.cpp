#include <array>
#include <cmath>

#include "schur/path_factor.hpp"

/// \file The elimination of the row that closes a ring. With S = [T e; e' s], T = L D L' of the path and the spike L^-1
/// e, it is
///
///   sigma = s - sum of spike^2/d,  y = b_c - sum of spike y/d,  lambda_c = -y/sigma,
///
/// and the path is left with the right side b + e lambda_c.
namespace tanor::detail {

/// Computes the spike in the next rows, and what they subtract from the closing row. The spike fades as rods bend.
/// Entries far below rounding are cut off, since numbers that underflow are slow.
void PathFactor::spread_spikes(const RodPath& path, const PathEquations& equations, paths::Half* left,
                               paths::Half* right) {
  constexpr double negligible = 1e-100;
  using Column = std::array<double, paths::chunk_size>;
  Column of_left{}, of_right{};  // e
  const auto enter = [&](paths::Half* half, Column* e) {
    const bool rightwards = half->is_rightwards();
    const std::size_t outermost = rightwards ? path.first : path.end - 1, k = outermost - half->first;
    if (k >= half->chunk.count) return;
    const std::size_t row = path.closing_row();
    const Vec3 g = equations.direction(path, row);
    // e = -g.g_c/m of the point between the two rods.
    (*e)[k] = half->coupling = -half->chunk.inverse_mass[rightwards ? k : k + 1] * dot(g, half->chunk.direction(k + 1));
  };
  enter(left, &of_left);
  enter(right, &of_right);
  const auto substitution = [&](const paths::Half& half, const Column& e) {
    return paths::Substitution{e.data(), factor_.data() + half.first, spike_.data() + half.first, half.chunk.count,
                               half.end.spike};
  };
  paths::Substitution to_right = substitution(*left, of_left), to_left = substitution(*right, of_right);
  paths::substitute_forward(&to_right, &to_left);
  left->end.spike = to_right.last;
  right->end.spike = to_left.last;
  for (paths::Half* half : {left, right}) {
    const std::size_t first = half->first, count = half->chunk.count;
    const double *const spike = spike_.data() + first, *const d = inverse_pivot_.data() + first;
    half->end.closing_pivot += paths::sum_of_products(spike, spike, d, count);
    if (equations.b != nullptr) half->end.closing_y += paths::sum_of_products(spike, equations.y + first, d, count);
    if (std::abs(half->end.spike) <= negligible * std::abs(half->coupling)) half->end.spike = 0.0;
  }
}

/// Eliminates the closing row after the middle row.
void PathFactor::eliminate_closing_row(std::size_t p, const PathEquations& equations, paths::PathWork* work) {
  const paths::Eliminated &left = work->left_end, &right = work->right_end;
  const RodPath& path = rows_.paths[p];
  const std::size_t row = path.closing_row(), middle = path.middle(), point = path.left_point(row);
  const Vec3 g = equations.evaluate_row(path, row);
  // In a path of two rows the middle row is the last one.
  const double coupling = middle + 1 == path.end
                              ? -rows_.inverse_mass[point] * dot(g, rows_.direction(equations.given_blocks, middle))
                              : 0.0;
  spike_[middle] = coupling - factor_[middle] * left.spike - right_factor_[p] * right.spike;
  const double diagonal = (rows_.inverse_mass[point] + rows_.inverse_mass[path.right_point(row)]) * dot(g, g);
  inverse_pivot_[row] = 1.0 / (diagonal - left.closing_pivot - right.closing_pivot -
                               spike_[middle] * spike_[middle] * inverse_pivot_[middle]);
  const double ratio = diagonal * inverse_pivot_[row];
  paths::Findings findings{.smallest_ratio = ratio, .largest_ratio = ratio};
  if (equations.b != nullptr) {
    findings.right_side = std::abs(equations.b[row]);
    substitute_closing_row(path, equations.b, equations.y, *work);
  }
  work->findings.include(findings);
}

void PathFactor::substitute_closing_row(const RodPath& path, const double* b, double* y,
                                        const paths::PathWork& work) const {
  const std::size_t row = path.closing_row(), middle = path.middle();
  y[row] =
      b[row] - work.left_end.closing_y - work.right_end.closing_y - spike_[middle] * inverse_pivot_[middle] * y[middle];
}

}  // namespace tanor::detail
