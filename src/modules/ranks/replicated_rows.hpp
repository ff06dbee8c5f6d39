#pragma once

#include <optional>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "factor/cholesky.hpp"

namespace tanor::detail {

/// Shared rows that every rank solves for itself, all of them, with one sum for a factorization and one for a solve.
class ReplicatedRows final : public SharedRows {
 public:
  /// `own` are the places, ascending, of this rank's shared rows among the `num_rows` of all ranks.
  ReplicatedRows(Ranks& ranks, std::size_t num_rows, std::span<const std::size_t> own, int threads);

  double factorize(std::span<const double> triangle) override;
  void solve(std::span<double> x) override;

 private:
  /// Returns the place of entry (i, j), i >= j, in the lower triangle of all rows.
  std::size_t entry(std::size_t i, std::size_t j) const { return j * (2 * x_.size() - j + 1) / 2 + i - j; }

  Ranks& ranks_;
  std::vector<std::size_t> own_;
  int threads_;
  Cholesky factor_;  // factor of one dense front
  std::vector<double> scale_, x_;
};

}  // namespace tanor::detail
