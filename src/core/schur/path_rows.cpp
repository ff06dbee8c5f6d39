#include "schur/path_rows.hpp"

#include <algorithm>
#include <cmath>

/// \file Rods between moving points are evaluated some at a time, those to supports one by one.
namespace tanor::detail {

using paths::chunk_size;

PathRows::PathRows(const SchurProblem& problem, std::vector<Index>* islands) : inverse_mass(problem.inverse_mass) {
  const Numbering& numbering = problem.numbering;
  RodRows rods(problem.constraints, numbering.num_rows());
  sign.assign(numbering.num_rows(), 1);
  std::erase_if(*islands, [&](Index island) {
    const std::optional<RodPath> path = find_path(rods.ends, numbering, island);
    if (!path) return false;
    for (std::size_t row = path->first; row < path->first + path->num_rows(); ++row)
      sign[row] = rods.ends[row][0] == static_cast<Index>(path->left_point(row)) ? 1 : -1;
    paths.push_back(*path);
    if (path->is_ring) ++num_rings;
    return true;
  });
  if (paths.empty()) return;
  read_offsets(rods.offset);
  length = std::move(rods.constant_length);
  moving_lengths = std::move(rods.lengths);
  first_block = rods.block[0];
  bool follow_rows = true;
  for (std::size_t row = 0; row < num_rows(); ++row) follow_rows = follow_rows && rods.block[row] == first_block + row;
  if (!follow_rows) block_numbers = std::move(rods.block);
}

void PathRows::read_offsets(std::span<const Vec3> offsets) {
  offset.assign(offsets.begin(), offsets.end());
  for (std::size_t row = 0; row < offset.size(); ++row) offset[row] = sign[row] * offset[row];
}

// ---- one row ----

Vec3 PathRows::distance(const RodPath& path, std::size_t row, const double* r) const {
  const Vec3 a = load(r, path.right_point(row)) - load(r, path.left_point(row));
  return offset.empty() ? a : a + offset[row];
}

double PathRows::right_side(const RodPath& path, std::size_t row, const FreeMotion& motion) const {
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

// ---- rods between moving points ----

paths::Rods PathRows::rods_between(const RodPath& path, std::size_t begin, std::size_t end,
                                   const FreeMotion& motion) const {
  const std::size_t point = 3 * path.left_point(begin);
  return {.r = motion.r + point,
          .v = motion.v == nullptr ? nullptr : motion.v + point,
          .w0 = motion.uniform != nullptr || motion.w0 == nullptr ? nullptr : motion.w0 + point,
          .offset = offset.empty() ? nullptr : &offset[begin].x,
          .sign = &sign[begin],
          .count = end - begin};
}

void PathRows::subtract_moving(std::size_t begin, std::size_t end, double MovingScalar::*part, double* rows) const {
  for (auto l = std::lower_bound(moving_lengths.begin(), moving_lengths.end(),
                                 std::pair<std::size_t, const MovingScalar*>(begin, nullptr));
       l != moving_lengths.end() && l->first < end; ++l)
    rows[l->first - begin] -= l->second->*part;
}

// ---- all rows ----

/// Returns the largest value of `between(path, begin, end)` and `alone(path, row)` over the rows of a range.
template <class Between, class Alone>
double PathRows::largest_of_rows(std::size_t range_begin, std::size_t range_end, const Between& between,
                                 const Alone& alone) const {
  double largest = 0.0;
  const auto is_before = [&](const RodPath& path) { return path.first + path.num_rows() <= range_begin; };
  for (auto path = std::partition_point(paths.begin(), paths.end(), is_before);
       path != paths.end() && path->first < range_end; ++path) {
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

void PathRows::take_lengths() {
  for (const auto& [row, moving] : moving_lengths) length[row] = moving->value;
}

double PathRows::find_values(std::size_t first, std::size_t last, const double* r, double* xi) const {
  return largest_of_rows(
      first, last,
      [&](const RodPath& path, std::size_t begin, std::size_t end) {
        return paths::evaluate_values(rods_between(path, begin, end, {r, nullptr, nullptr}), &length[begin],
                                      xi + begin);
      },
      [&](const RodPath& path, std::size_t row) {
        xi[row] = norm(distance(path, row, r)) - length[row];
        return std::abs(xi[row]) / length[row];
      });
}

double PathRows::find_rates(std::size_t first, std::size_t last, const double* r, const double* v,
                            double* rates) const {
  return largest_of_rows(
      first, last,
      [&](const RodPath& path, std::size_t begin, std::size_t end) {
        const double largest = paths::evaluate_rates(rods_between(path, begin, end, {r, v, nullptr}), rates + begin);
        if (moving_lengths.empty()) return largest;
        subtract_moving(begin, end, &MovingScalar::first, rates + begin);
        return paths::largest_magnitude(rates + begin, end - begin, 0.0);
      },
      [&](const RodPath& path, std::size_t row) {
        const Vec3 velocity = load(v, path.right_point(row)) - load(v, path.left_point(row));
        rates[row] = Distance(distance(path, row, r), velocity).first;
        subtract_moving(row, row + 1, &MovingScalar::first, rates + row);
        return std::abs(rates[row]);
      });
}

double PathRows::find_right_sides(std::size_t first, std::size_t last, const FreeMotion& motion, double* b) const {
  return largest_of_rows(
      first, last,
      [&](const RodPath& path, std::size_t begin, std::size_t end) {
        paths::evaluate_right_side(rods_between(path, begin, end, motion), b + begin);
        subtract_moving(begin, end, &MovingScalar::second, b + begin);
        return paths::largest_magnitude(b + begin, end - begin, 0.0);
      },
      [&](const RodPath& path, std::size_t row) { return std::abs(b[row] = right_side(path, row, motion)); });
}

}  // namespace tanor::detail
