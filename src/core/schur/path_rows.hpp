#pragma once

#include <span>
#include <utility>
#include <vector>

#include "plan/thresholds.hpp"
#include "schur/path_kernels.hpp"
#include "schur/rod_rows.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// The rods of paths and rings row by row, and their equations at given positions. Arrays by row have the rows of the
/// whole system.
struct PathRows {
  std::span<const double> inverse_mass;  ///< [point]
  std::vector<RodPath> paths;
  std::size_t num_rings = 0;  ///< number of rings among them
  std::size_t first_block = 0;
  std::vector<std::size_t> block_numbers;  ///< [row]; empty if they follow the rows from the first block on
  std::vector<signed char> sign;           ///< [row] sign of its block, along the path
  std::vector<Vec3> offset;                ///< [row] along the path; empty if there are none
  std::vector<double> length;              ///< [row]
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths;  ///< lengths that depend on time, by row

  /// Takes the islands that are paths or rings out of `islands`.
  PathRows(const SchurProblem& problem, std::vector<Index>* islands);

  void read_offsets(std::span<const Vec3> offsets);

  std::size_t num_rows() const { return sign.size(); }
  bool blocks_follow_rows() const { return block_numbers.empty(); }
  std::size_t block(std::size_t row) const { return blocks_follow_rows() ? first_block + row : block_numbers[row]; }

  // ---- one row, along its path ----

  /// Returns r_right - r_left + offset.
  Vec3 distance(const RodPath& path, std::size_t row, const double* r) const;
  Vec3 direction(const double* blocks, std::size_t row) const { return sign[row] * load(blocks, block(row)); }
  /// Returns phi + K'w0 with phi = rho'' - l''.
  double right_side(const RodPath& path, std::size_t row, const FreeMotion& motion) const;

  // ---- rows [begin, end) of one path, whose rods join moving points ----

  paths::Rods rods_between(const RodPath& path, std::size_t begin, std::size_t end, const FreeMotion& motion) const;
  /// Subtracts a derivative of the lengths that move from `rows`, which begin with row `begin`.
  void subtract_moving(std::size_t begin, std::size_t end, double MovingScalar::*part, double* rows) const;

  // ---- all rows [begin, end) of paths; each returns the largest |xi|/length, |rate| or |b| ----

  void take_lengths();
  double find_values(std::size_t begin, std::size_t end, const double* r, double* xi) const;
  double find_rates(std::size_t begin, std::size_t end, const double* r, const double* v, double* rates) const;
  double find_right_sides(std::size_t begin, std::size_t end, const FreeMotion& motion, double* b) const;
  /// Returns the largest value of find(begin, end) over all rows. The rows are taken in the same chunks for any number
  /// of threads, because a chunk belongs to the range in which it begins.
  template <class Find>
  double largest_of_ranges(const Parallel& parallel, const Find& find) const {
    const std::size_t first = paths.front().first, count = paths.back().first + paths.back().num_rows() - first;
    return parallel.max_over_ranges(
        count, [&](std::size_t begin, std::size_t end) { return find(first + begin, first + end); },
        plan::rows_worth_a_thread);
  }

 private:
  template <class Between, class Alone>
  double largest_of_rows(std::size_t begin, std::size_t end, const Between& between, const Alone& alone) const;
};

}  // namespace tanor::detail
