#pragma once

#include <omp.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <exception>
#include <numeric>
#include <type_traits>

#include "base/quiet_traps.hpp"

namespace tanor::detail {

/// Returns the larger of two numbers. A NaN wins, so that it cannot hide in a maximum.
inline double larger(double a, double b) {
  return (b > a || std::isnan(b)) ? b : a;
}

/// Loops over index ranges with a given number of threads.
///
/// The indices are cut into ranges, one for each thread. Results must not depend on where the cuts lie: each index
/// writes its own output, and maxima are associative. One and two threads then give the same bits. An exception inside
/// a loop is rethrown after it.
class Parallel {
 public:
  /// Indices of a plain loop from which a thread pays; with fewer, waking it takes longer (bench/linear_solvers
  /// --threads 2: sheet 60).
  static constexpr std::size_t worth_a_thread = 4096;

  explicit Parallel(int threads = 0) : threads_(threads > 0 ? threads : omp_get_max_threads()) {}

  int threads() const { return threads_; }

  /// Calls body(begin, end) for a partition of [0, count). Ranges shorter than `grain` are not worth a thread.
  template <class Body>
  void for_ranges(std::size_t count, const Body& body, std::size_t grain = worth_a_thread) const {
    const std::size_t ranges = num_ranges(count, grain);
    if (ranges <= 1) {
      body(std::size_t{0}, count);
      return;
    }
    std::exception_ptr failure;
    const int threads = static_cast<int>(ranges);
#pragma omp parallel for num_threads(threads) schedule(static, 1)
    for (std::size_t k = 0; k < ranges; ++k) {
      const QuietTraps quiet;  // this thread may be one of the host's
      try {
        body(count * k / ranges, count * (k + 1) / ranges);
      } catch (...) {
#pragma omp critical(tanor_parallel_failure)
        failure = std::current_exception();
      }
    }
    if (failure) std::rethrow_exception(failure);
  }

  /// Joins what body(begin, end) returns for each of the ranges, by result = join(result, part), to `result`. The join
  /// must not depend on the order of the parts.
  template <class Result, class Body, class Join>
  Result join_over_ranges(std::size_t count, Result result, const Body& body, const Join& join,
                          std::size_t grain = worth_a_thread) const {
    if (num_ranges(count, grain) <= 1) return join(result, body(std::size_t{0}, count));
    for_ranges(
        count,
        [&](std::size_t begin, std::size_t end) {
          const Result part = body(begin, end);
#pragma omp critical(tanor_parallel_join)
          result = join(result, part);
        },
        grain);
    return result;
  }

  /// Returns the largest body(begin, end) over the ranges, at least 0, or NaN if one of them is.
  template <class Body>
  double max_over_ranges(std::size_t count, const Body& body, std::size_t grain = worth_a_thread) const {
    return join_over_ranges(count, 0.0, body, larger, grain);
  }

  /// Returns the sum of term(k) over [0, count). Its order does not depend on the number of threads: 64 parts are
  /// summed, then their sums.
  template <class Term>
  double sum(std::size_t count, const Term& term, std::size_t grain = worth_a_thread) const {
    std::array<double, num_parts> parts;  // NOLINT: each is written
    if (count <= parts.size()) {          // each part has one term at most
      double result = 0.0;
      for (std::size_t k = 0; k < count; ++k) result += term(k);
      return result;
    }
    const auto add_parts = [&](std::size_t begin, std::size_t end) {
      std::size_t p = begin;
      for (; p + side_by_side <= end; p += side_by_side) add_side_by_side(count, term, p, &parts[p]);
      for (; p < end; ++p) parts[p] = add(count * p / num_parts, count * (p + 1) / num_parts, term, 0.0);
    };
    for_ranges(parts.size(), add_parts, std::max<std::size_t>(1, parts.size() * grain / (count + 1)));
    return std::accumulate(parts.begin(), parts.end(), 0.0);
  }

  /// Calls body(k), or body(k, thread) with thread < threads(), for a few large tasks of unequal size.
  template <class Body>
  void for_tasks(std::size_t count, const Body& body) const {
    const auto run = [&](std::size_t k, std::size_t thread) {
      if constexpr (std::is_invocable_v<const Body&, std::size_t, std::size_t>) {
        body(k, thread);
      } else {
        body(k);
      }
    };
    if (threads_ <= 1 || count <= 1) {
      for (std::size_t k = 0; k < count; ++k) run(k, 0);
      return;
    }
    std::exception_ptr failure;
#pragma omp parallel for num_threads(threads_) schedule(dynamic, 1)
    for (std::size_t k = 0; k < count; ++k) {
      const QuietTraps quiet;
      try {
        run(k, static_cast<std::size_t>(omp_get_thread_num()));
      } catch (...) {
#pragma omp critical(tanor_parallel_failure)
        failure = std::current_exception();
      }
    }
    if (failure) std::rethrow_exception(failure);
  }

 private:
  static constexpr std::size_t num_parts = 64, side_by_side = 4;  // parts of a sum, and how many are added at once

  template <class Term>
  static double add(std::size_t begin, std::size_t end, const Term& term, double sum) {
    for (std::size_t k = begin; k < end; ++k) sum += term(k);
    return sum;
  }
  /// Adds the parts from p on side by side, because within a part each addition waits for the one before it.
  template <class Term>
  static void add_side_by_side(std::size_t count, const Term& term, std::size_t p, double* parts) {
    const std::size_t common = count / num_parts;  // no part has fewer terms
    std::array<std::size_t, side_by_side> first;   // NOLINT: filled before use
    for (std::size_t q = 0; q < side_by_side; ++q) first[q] = count * (p + q) / num_parts;
    std::array<double, side_by_side> sums{};
    for (std::size_t k = 0; k < common; ++k) {
      for (std::size_t q = 0; q < side_by_side; ++q) sums[q] += term(first[q] + k);
    }
    for (std::size_t q = 0; q < side_by_side; ++q)
      parts[q] = add(first[q] + common, count * (p + q + 1) / num_parts, term, sums[q]);
  }

  std::size_t num_ranges(std::size_t count, std::size_t grain) const {
#ifdef TANOR_SMALLEST_RANGES  // the thread sanitizer divides small systems as well
    grain = std::min<std::size_t>(grain, 4);
#endif
    return std::min<std::size_t>(static_cast<std::size_t>(threads_), count / grain);
  }

  int threads_;
};

}  // namespace tanor::detail
