#include <algorithm>
#include <cmath>

#include "plan/thresholds.hpp"

#include "schur/path_solver.hpp"

/// \file What the rows of PathSolver say at given places: rods between moving points some at a time, those to supports
/// one by one.
namespace tanor {

using paths::chunk_size;

// ---- one row ----

/// r_right - r_left + offset
Vec3 PathSolver::distance(const Path& path, std::size_t row, const double* r) const {
  const Vec3 a = load(r, path.right_point(row)) - load(r, path.left_point(row));
  return offset_.empty() ? a : a + offset_[row];
}

/// phi + K'w0 with phi = rho'' - l''
double PathSolver::right_side(const Path& path, std::size_t row, const FreeMotion& motion) const {
  const double *const r = motion.r, *const v = motion.v, *const w0 = motion.w0;
  const Vec3* const uniform = motion.uniform;
  const std::size_t i = path.left_point(row), j = path.right_point(row);
  const Distance rho(distance(path, row, r), load(v, j) - load(v, i));
  const Vec3 left = uniform != nullptr && !path.begins_at_support(row) ? *uniform : load(w0, i);
  const Vec3 right = uniform != nullptr && !path.ends_at_support(row) ? *uniform : load(w0, j);
  double b = rho.second + dot(rho.unit, right - left);
  subtract_moving(row, row + 1, &MovingScalar::second, &b);
  return b;
}

/// Along the path.
Vec3 PathSolver::direction(const Path& path, std::size_t row, const Numbers& numbers) const {
  if (numbers.motion == nullptr) return direction(numbers.given_blocks, row);
  const Vec3 a = distance(path, row, numbers.motion->r);
  return (1.0 / norm(a)) * a;
}

/// Its block and b; returns its direction along the path.
Vec3 PathSolver::evaluate_row(const Path& path, std::size_t row, const Numbers& numbers) const {
  const Vec3 g = direction(path, row, numbers);
  if (numbers.motion == nullptr) return g;
  if (numbers.b != nullptr) numbers.b[row] = right_side(path, row, *numbers.motion);
  store(numbers.blocks, block(row), sign_[row] * g);
  return g;
}

// ---- rows [begin, end) of one path, whose rods join moving points ----

paths::Rods PathSolver::rods_between(const Path& path, std::size_t begin, std::size_t end,
                                     const FreeMotion& motion) const {
  const std::size_t point = 3 * path.left_point(begin);
  return {.r = motion.r + point,
          .v = motion.v == nullptr ? nullptr : motion.v + point,
          .w0 = motion.uniform != nullptr || motion.w0 == nullptr ? nullptr : motion.w0 + point,
          .offset = offset_.empty() ? nullptr : &offset_[begin].x,
          .sign = &sign_[begin],
          .count = end - begin};
}

/// A derivative of the lengths that move, from `rows`, which begin with row `begin`.
void PathSolver::subtract_moving(std::size_t begin, std::size_t end, double MovingScalar::*part, double* rows) const {
  for (auto l = std::lower_bound(lengths_.begin(), lengths_.end(),
                                 std::pair<std::size_t, const MovingScalar*>(begin, nullptr));
       l != lengths_.end() && l->first < end; ++l)
    rows[l->first - begin] -= l->second->*part;
}

// ---- all rows ----

/// The largest one of what find(begin, end) returns. Rows are taken in the same chunks whatever the number of threads:
/// a chunk belongs to the range that it begins in.
template <class Find>
double PathSolver::largest_of_ranges(const Parallel& parallel, const Find& find) const {
  const std::size_t first = paths_.front().first, num_rows = paths_.back().first + paths_.back().num_rows() - first;
  return parallel.max_over_ranges(
      num_rows, [&](std::size_t begin, std::size_t end) { return find(first + begin, first + end); },
      plan::rows_worth_a_thread);
}

/// The largest one of what `between(path, begin, end)` and `alone(path, row)` return.
template <class Between, class Alone>
double PathSolver::largest_of_rows(std::size_t range_begin, std::size_t range_end, const Between& between,
                                   const Alone& alone) const {
  double largest = 0.0;
  const auto is_before = [&](const Path& path) { return path.first + path.num_rows() <= range_begin; };
  for (auto path = std::partition_point(paths_.begin(), paths_.end(), is_before);
       path != paths_.end() && path->first < range_end; ++path) {
    const std::size_t skipped = range_begin > path->first ? range_begin - path->first : 0;
    std::size_t row = path->first + (skipped + chunk_size - 1) / chunk_size * chunk_size;
    for (std::size_t last = row; row < std::min(path->end, range_end); row = last) {
      last = std::min(row + chunk_size, path->end);
      const std::size_t begin = path->begins_at_support(row) ? row + 1 : row;
      const std::size_t rods_end = path->ends_at_support(last - 1) ? last - 1 : last;
      if (row < begin) largest = larger(largest, alone(*path, row));
      if (begin < rods_end) largest = larger(largest, between(*path, begin, rods_end));
      if (rods_end < last && rods_end >= begin) largest = larger(largest, alone(*path, rods_end));
    }
    if (path->is_ring && path->closing_row() < range_end) largest = larger(largest, alone(*path, path->closing_row()));
  }
  return largest;
}

void PathSolver::take_lengths() {
  for (const auto& [row, length] : lengths_) length_[row] = length->value;
}

double PathSolver::find_values(std::size_t first, std::size_t last, const double* r, double* xi) const {
  return largest_of_rows(
      first, last,
      [&](const Path& path, std::size_t begin, std::size_t end) {
        return paths::evaluate_values(rods_between(path, begin, end, {r, nullptr, nullptr}), &length_[begin],
                                      xi + begin);
      },
      [&](const Path& path, std::size_t row) {
        xi[row] = norm(distance(path, row, r)) - length_[row];
        return std::abs(xi[row]) / length_[row];
      });
}

double PathSolver::find_rates(std::size_t first, std::size_t last, const double* r, const double* v,
                              double* rates) const {
  return largest_of_rows(
      first, last,
      [&](const Path& path, std::size_t begin, std::size_t end) {
        paths::evaluate_rates(rods_between(path, begin, end, {r, v, nullptr}), rates + begin);
        subtract_moving(begin, end, &MovingScalar::first, rates + begin);
        return paths::largest_magnitude(rates + begin, end - begin, 0.0);
      },
      [&](const Path& path, std::size_t row) {
        const Vec3 velocity = load(v, path.right_point(row)) - load(v, path.left_point(row));
        rates[row] = Distance(distance(path, row, r), velocity).first;
        subtract_moving(row, row + 1, &MovingScalar::first, rates + row);
        return std::abs(rates[row]);
      });
}

double PathSolver::evaluate_values(const Parallel& parallel, const double* r, double* xi) {
  take_lengths();
  return largest_of_ranges(parallel,
                           [&](std::size_t begin, std::size_t end) { return find_values(begin, end, r, xi); });
}

double PathSolver::evaluate_rates(const Parallel& parallel, const double* r, const double* v, double* rates) {
  return largest_of_ranges(parallel,
                           [&](std::size_t begin, std::size_t end) { return find_rates(begin, end, r, v, rates); });
}

double PathSolver::evaluate_right_side(const Parallel& parallel, const FreeMotion& motion, double* b) const {
  return largest_of_ranges(parallel, [&](std::size_t first, std::size_t last) {
    return largest_of_rows(
        first, last,
        [&](const Path& path, std::size_t begin, std::size_t end) {
          paths::evaluate_right_side(rods_between(path, begin, end, motion), b + begin);
          subtract_moving(begin, end, &MovingScalar::second, b + begin);
          return paths::largest_magnitude(b + begin, end - begin, 0.0);
        },
        [&](const Path& path, std::size_t row) { return std::abs(b[row] = right_side(path, row, motion)); });
  });
}

}  // namespace tanor
