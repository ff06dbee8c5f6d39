#include <array>
#include <cmath>

#include "schur/path_half.hpp"

/// \file The row that closes a ring. With S = [T e; e' s], T = L D L' of the path and the spike L^-1 e,
///
///   sigma = s - sum of spike^2/d,  y = b_c - sum of spike y/d,  lambda_c = -y/sigma,
///
/// and the path is left with the right side b + e lambda_c.
namespace tanor {

/// The spike in the next rows, and what they take from the closing row. It fades as rods bend; what is far below
/// rounding is cut off, since numbers that underflow are slow.
void PathSolver::spread_spikes(const Path& path, const Numbers& numbers, Half* left, Half* right) {
  constexpr double negligible = 1e-100;
  using Column = std::array<double, paths::chunk_size>;
  Column of_left{}, of_right{};  // e
  const auto enter = [&](Half* half, Column* e) {
    const bool rightwards = half->is_rightwards();
    const std::size_t outermost = rightwards ? path.first : path.end - 1, k = outermost - half->first;
    if (k >= half->chunk.count) return;
    const std::size_t row = path.closing_row();
    const Vec3 g = direction(path, row, numbers);
    // e = -g.g_c/m of the point between
    (*e)[k] = half->coupling = -half->chunk.inverse_mass[rightwards ? k : k + 1] * dot(g, half->chunk.direction(k + 1));
  };
  enter(left, &of_left);
  enter(right, &of_right);
  const auto substitution = [&](const Half& half, const Column& e) {
    return paths::Substitution{e.data(), factor_.data() + half.first, spike_.data() + half.first, half.chunk.count,
                               half.end.spike};
  };
  paths::Substitution to_right = substitution(*left, of_left), to_left = substitution(*right, of_right);
  paths::substitute_inwards(&to_right, &to_left);
  left->end.spike = to_right.last;
  right->end.spike = to_left.last;
  for (Half* half : {left, right}) {
    const std::size_t first = half->first, count = half->chunk.count;
    const double *const spike = spike_.data() + first, *const d = inverse_pivot_.data() + first;
    half->end.closing_pivot += paths::sum_of_products(spike, spike, d, count);
    if (numbers.b != nullptr) half->end.closing_y += paths::sum_of_products(spike, numbers.y + first, d, count);
    if (std::abs(half->end.spike) <= negligible * std::abs(half->coupling)) half->end.spike = 0.0;
  }
}

/// After the middle row.
void PathSolver::eliminate_closing_row(std::size_t p, const Numbers& numbers, Work* work) {
  const Eliminated &left = work->left_end, &right = work->right_end;
  const Path& path = paths_[p];
  const std::size_t row = path.closing_row(), middle = path.middle(), point = path.left_point(row);
  const Vec3 g = evaluate_row(path, row, numbers);
  // A path of two rows ends with its middle.
  const double coupling =
      middle + 1 == path.end ? -inverse_mass_[point] * dot(g, direction(numbers.given_blocks, middle)) : 0.0;
  spike_[middle] = coupling - factor_[middle] * left.spike - right_factor_[p] * right.spike;
  const double diagonal = (inverse_mass_[point] + inverse_mass_[path.right_point(row)]) * dot(g, g);
  inverse_pivot_[row] = 1.0 / (diagonal - left.closing_pivot - right.closing_pivot -
                               spike_[middle] * spike_[middle] * inverse_pivot_[middle]);
  const double ratio = diagonal * inverse_pivot_[row];
  Range range{.smallest_ratio = ratio, .largest_ratio = ratio};
  if (numbers.b != nullptr) {
    range.right_side = std::abs(numbers.b[row]);
    eliminate_closing_row_of(path, numbers.b, numbers.y, *work);
  }
  work->range.include(range);
}

void PathSolver::eliminate_closing_row_of(const Path& path, const double* b, double* y, const Work& work) const {
  const std::size_t row = path.closing_row(), middle = path.middle();
  y[row] =
      b[row] - work.left_end.closing_y - work.right_end.closing_y - spike_[middle] * inverse_pivot_[middle] * y[middle];
}

}  // namespace tanor
