#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dynamics/workspace.hpp"
#include "factor/cholesky.hpp"
#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// The second factorization of K'WK. Auto is QR, or Cholesky if R would take too much memory.
enum class SecondFactorization { Auto, Qr, Cholesky };

/// Solves with K'WK a second time, sharing nothing with GramSolver but the blocks of K: C = W^1/2 K with unit columns
/// and R of its QR factorization, or its own C'C in another elimination order.
class SecondFactor {
 public:
  /// Factorizes K in `blocks` with `weights` [point]: 1/m for S, 1 for Gamma, 0 at supports. `first_orderings` are
  /// those of the GramSolver.
  SecondFactor(const Model& model, const double* blocks, std::span<const double> weights,
               std::span<const Ordering> first_orderings, SecondFactorization by);

  /// Tells why there is no factor; empty if there is one.
  const std::string& trouble() const { return trouble_; }
  const char* name() const { return is_qr_ ? "QR" : "another Cholesky"; }
  /// Sets rows := -(K'WK)^-1 rows [rows]; rows that depend on others become 0.
  void solve_negative(double* rows);
  /// Returns |column of W^1/2 K| of each inner row; 1 if that is 0.
  const std::vector<double>& lengths() const { return lengths_; }
  /// Estimates the reciprocal condition of C'C by a few inverse iterations.
  double estimate_reciprocal_condition();

 private:
  SparseColumns scaled_columns(const Model& model, const double* blocks, std::span<const double> weights);
  void keep_apart(const Model& model, const double* blocks, std::span<const double> weights, const SparseColumns& C);
  void factorize(const SparseColumns& C, Ordering ordering);
  void solve();  // packed_ := (C'C)^-1 packed_

  bool is_qr_;
  std::string trouble_;
  std::vector<double> lengths_, packed_;
  std::vector<int> row_of_;         // [place in packed_] -> inner row
  std::vector<int> row_of_column_;  // [column of C] -> inner row
  TriangularFactor R_;
  std::optional<Cholesky> L_;
  double largest_column_sum_ = 0.0;  // upper bound of that of C'C
};

}  // namespace tanor::detail
