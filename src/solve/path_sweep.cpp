#include "solve/path_sweep.hpp"

#include <algorithm>
#include <cmath>

namespace tanor {

std::unique_ptr<PathSweep> PathSweep::make(const Constraints& constraints, const Numbering& numbering,
                                           std::span<const double> inverse_mass) {
  const std::size_t num_rows = numbering.num_rows();
  std::unique_ptr<PathSweep> result(new PathSweep);
  result->inverse_mass_ = inverse_mass;
  std::vector<std::array<Index, 2>> ends(num_rows, {-1, -1});
  result->block_.assign(num_rows, -1);
  const auto read = [&]<bool Timed, bool Shifted>(const Family<RodKernel<Timed, Shifted>>& rods) {
    if ((Timed || Shifted) && rods.size() > 0) result->extra_.resize(num_rows);
    for (std::size_t k = 0; k < rods.size(); ++k) {
      const auto row = static_cast<std::size_t>(rods.rows[k]);
      ends[row] = rods.kernel.points[k];
      result->block_[row] = rods.first_block + static_cast<Index>(k);
      if constexpr (Shifted) result->extra_[row].offset = rods.kernel.offset[k];
      if constexpr (Timed) result->extra_[row].length = &rods.kernel.moving_length[k];
    }
  };
  read(constraints.family<RodKernel<false, false>>());
  read(constraints.family<RodKernel<false, true>>());
  read(constraints.family<RodKernel<true, false>>());
  read(constraints.family<RodKernel<true, true>>());

  const auto num_moving = static_cast<Index>(numbering.num_moving);
  result->sign_.assign(num_rows, 1.0);
  for (std::size_t island = 0; island < numbering.num_islands(); ++island) {
    Path path{.first_row = numbering.island_start[island],
              .num_rows = numbering.island_start[island + 1] - numbering.island_start[island],
              .first_point = 0,
              .num_points = 0};
    const auto ends_of = [&](Index k) { return ends[static_cast<std::size_t>(path.first_row + k)]; };
    for (Index k = 0; k < path.num_rows; ++k) {
      if (ends_of(k)[0] < 0) return nullptr;  // no rod
    }
    const auto [i, j] = ends_of(0);
    const auto [low, high] = std::minmax(i, j);
    path.first_point = low;
    if (high >= num_moving) path.left_support = high;
    const auto [p, q] = ends_of(path.num_rows - 1);
    const Index last = std::max(p, q);
    if (path.num_rows > 1 && last >= num_moving) path.right_support = last;
    path.num_points = path.num_rows + 1 - (path.left_support >= 0 ? 1 : 0) - (path.right_support >= 0 ? 1 : 0);
    for (Index k = 0; k < path.num_rows; ++k) {
      const Index left = path.left_point(k), right = path.right_point(k);
      const std::array<Index, 2>& given = ends_of(k);
      const bool is_reversed = given[0] == right && given[1] == left;
      if (!is_reversed && !(given[0] == left && given[1] == right)) return nullptr;
      if (is_reversed) result->sign_[static_cast<std::size_t>(path.first_row + k)] = -1.0;
    }
    result->paths_.push_back(path);
  }
  for (std::vector<double>* array : {&result->inverse_pivot_, &result->factor_, &result->other_factor_})
    array->resize(num_rows);
  constexpr double flops_a_row = 4.0;
  result->summary_ = {.name = "paths",
                      .reason = "every island is a path of rods",
                      .parts = result->paths_.size(),
                      .pattern_nonzeros = 2 * num_rows - result->paths_.size(),
                      .factor_nonzeros = 2 * num_rows - result->paths_.size(),
                      .flops = flops_a_row * static_cast<double>(num_rows)};
  return result;
}

/// Along the path.
Vec3 PathSweep::gradient(const double* blocks, Index row) const {
  const auto a = static_cast<std::size_t>(row);
  return sign_[a] * load(blocks, block_[a]);
}

Elimination PathSweep::solve(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b,
                             double* lambda, double* w) {
  Elimination result = eliminate(parallel, motion, blocks, b, lambda);
  if (result.reciprocal_condition > 0.0) result.residual = substitute(parallel, motion.uniform, blocks, b, lambda, w);
  return result;
}

/// The first sweep; b is eliminated too, in lambda.
Elimination PathSweep::eliminate(const Parallel& parallel, const FreeMotion& motion, double* blocks, double* b,
                                 double* lambda) {
  const auto& [r, v, w0, uniform] = motion;
  Elimination result;
  for (const Path& path : paths_) {
    for (Index k = 0; k < path.num_rows; ++k) {
      const Index i = path.left_point(k), j = path.right_point(k), row = path.first_row + k;
      const auto a = static_cast<std::size_t>(row);
      const auto w0_of = [&, w0 = w0, uniform = uniform](Index point) {
        return uniform != nullptr && inverse_mass(point) > 0.0 ? *uniform : load(w0, point);
      };
      Vec3 d = load(r, j) - load(r, i);
      if (!extra_.empty()) d = d + sign_[a] * extra_[a].offset;
      const Distance rho(d, load(v, j) - load(v, i));
      store(blocks, block_[a], sign_[a] * rho.unit);
      // phi = rho'' - l'', and K'w0
      b[a] = rho.second + dot(rho.unit, w0_of(j) - w0_of(i));
      if (!extra_.empty() && extra_[a].length != nullptr) b[a] -= extra_[a].length->second;
      result.largest_right_side = larger(result.largest_right_side, std::abs(b[a]));
    }
  }
  result.reciprocal_condition = factorize(parallel, blocks).reciprocal_condition;
  for (const Path& path : paths_) eliminate_right_side(path, b, lambda);
  return result;
}

Elimination PathSweep::factorize(const Parallel&, const double* blocks) {
  Elimination result;
  for (const Path& path : paths_)
    result.reciprocal_condition = std::min(result.reciprocal_condition, factorize(path, blocks).reciprocal_condition);
  return result;
}

/// Pivots d_a = S_aa - sum over the neighbours n eliminated before of S_an^2/d_n.
Elimination PathSweep::factorize(const Path& path, const double* blocks) {
  double smallest = 1.0;
  bool is_fine = true;
  const auto find_pivot = [&](Index k, Index before, Index after) {
    const Index row = path.first_row + k;
    const auto a = static_cast<std::size_t>(row);
    const Vec3 g = gradient(blocks, row);
    const double left = inverse_mass(path.left_point(k)), right = inverse_mass(path.right_point(k));
    double pivot = left + right;
    if (before >= 0) {
      const double c = -left * dot(g, gradient(blocks, row - 1));
      factor_[a] = c * inverse_pivot_[a - 1];
      pivot -= c * factor_[a];
    }
    if (after >= 0) {
      const double c = -right * dot(g, gradient(blocks, row + 1));
      double& factor = before >= 0 ? other_factor_[a] : factor_[a];
      factor = c * inverse_pivot_[a + 1];
      pivot -= c * factor;
    }
    smallest = std::min(smallest, pivot / (left + right));
    is_fine = is_fine && pivot > 0.0;
    inverse_pivot_[a] = 1.0 / pivot;
  };
  const Index middle = path.middle();
  for (Index k = 0; k < middle; ++k) find_pivot(k, k - 1, -1);
  for (Index k = path.num_rows - 1; k > middle; --k) find_pivot(k, -1, k + 1 < path.num_rows ? k + 1 : -1);
  find_pivot(middle, middle - 1, middle + 1 < path.num_rows ? middle + 1 : -1);
  return {.reciprocal_condition = is_fine ? smallest : 0.0};
}

void PathSweep::eliminate_right_side(const Path& path, const double* b, double* y) const {
  const std::size_t first = static_cast<std::size_t>(path.first_row), middle = first + path.middle();
  const std::size_t end = first + path.num_rows;
  for (std::size_t a = first; a < middle; ++a) y[a] = b[a] - (a > first ? factor_[a] * y[a - 1] : 0.0);
  for (std::size_t a = end; a-- > middle + 1;) y[a] = b[a] - (a + 1 < end ? factor_[a] * y[a + 1] : 0.0);
  y[middle] = b[middle];
  if (middle > first) y[middle] -= factor_[middle] * y[middle - 1];
  if (middle + 1 < end) y[middle] -= (middle > first ? other_factor_ : factor_)[middle] * y[middle + 1];
}

/// y := -(its solution), outwards from the middle.
void PathSweep::substitute(const Path& path, double* y) const {
  const std::size_t first = static_cast<std::size_t>(path.first_row), middle = first + path.middle();
  const std::size_t end = first + path.num_rows;
  y[middle] *= -inverse_pivot_[middle];
  const bool has_left = middle > first;
  for (std::size_t a = middle; a-- > first;) y[a] = -y[a] * inverse_pivot_[a] - factor_[a + 1] * y[a + 1];
  for (std::size_t a = middle + 1; a < end; ++a) {
    const double factor = a == middle + 1 && has_left ? other_factor_[middle] : factor_[a - 1];
    y[a] = -y[a] * inverse_pivot_[a] - factor * y[a - 1];
  }
}

double PathSweep::substitute(const Parallel&, const Vec3* uniform, const double* blocks, const double* b,
                             double* lambda, double* w) {
  double worst = 0.0;
  for (const Path& path : paths_) {
    substitute(path, lambda);
    // Point p lies between row p - first and the one before, or after a support's.
    Vec3 before{};  // M^-1 K lambda of the point on the left
    for (Index k = 0; k < path.num_rows; ++k) {
      const Index row = path.first_row + k;
      const Vec3 g = gradient(blocks, row);
      const Vec3 force = lambda[row] * g;
      if (k == 0 && path.left_support < 0) before = -inverse_mass(path.left_point(k)) * force;
      Vec3 after{};
      if (const Index right = path.right_point(k); right != path.right_support) {
        after = k + 1 < path.num_rows ? force - lambda[row + 1] * gradient(blocks, row + 1) : force;
        after = inverse_mass(right) * after;
      }
      worst = larger(worst, std::abs(dot(g, after - before) + b[row]));
      if (const Index left = path.left_point(k); left != path.left_support)
        store(w, left, (uniform != nullptr ? *uniform : load(w, left)) + before);
      if (const Index right = path.right_point(k); k + 1 == path.num_rows && right != path.right_support)
        store(w, right, (uniform != nullptr ? *uniform : load(w, right)) + after);
      before = after;
    }
  }
  return worst;
}

void PathSweep::solve_negative(const Parallel&, const double* b, double* x) {
  for (const Path& path : paths_) {
    eliminate_right_side(path, b, x);
    substitute(path, x);
  }
}

}  // namespace tanor
