#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <tanor/solver_options.hpp>

#include "factor/cholesky.hpp"
#include "factor/multifrontal.hpp"

namespace tanor::detail {

/// Returns an order of elimination, [place] -> row, of a pattern (lower triangle) that keeps some rows for the end, in
/// the order that they have. The other rows are ordered by `wanted` as if the kept ones were not there.
std::vector<int> order_keeping(const TrianglePattern& lower, std::span<const char> is_kept, Ordering wanted);

/// Eliminates the first rows of a symmetric matrix and keeps the last ones, G, for the caller. The factor is the part
/// of a multifrontal one below its last front, which is assembled and handed over,
///
///   [ S_II  S_IG ]     L L' = S_II,   C = S_GG - S_GI S_II^-1 S_IG   (Schur complement)
///   [ S_GI  S_GG ]
///
/// Only S_II has to be positive definite. The parts of a matrix on several machines are summed in C; what a part
/// contributes to the kept rows may be singular by itself.
class PartialCholesky {
 public:
  /// Takes the lower triangle with its rows in the order of elimination, the kept ones last.
  PartialCholesky(TrianglePattern lower, std::size_t num_kept);

  const TrianglePattern& pattern() const { return pattern_; }
  std::size_t num_kept() const { return num_kept_; }
  std::size_t num_eliminated() const { return pattern_.size() - num_kept_; }
  std::size_t num_stored() const { return fronts_.num_stored(); }  ///< numbers of L and of C
  double* values() { return values_.data(); }  ///< beside pattern().rows; to be filled before `factorize`

  /// Factorizes the values. Any number of threads gives the same bits. The kept rows have no part in the quality.
  [[nodiscard]] Cholesky::Quality factorize(int threads = 1);

  /// Numbers of C's lower triangle, and the triangle itself, column after column.
  std::size_t complement_size() const { return num_kept_ * (num_kept_ + 1) / 2; }
  void write_complement(double* packed) const;

  /// The two halves of a solve of S x = b, called one after the other. `eliminate` takes b and leaves b_G - S_GI
  /// S_II^-1 b_I, the right side of C x_G, in the last numbers. `substitute` takes x_G there and leaves x.
  void eliminate(double* x, int threads = 1) { fronts_.eliminate(x, threads); }
  void substitute(double* x, int threads = 1) { fronts_.substitute(x, threads); }

 private:
  TrianglePattern pattern_;
  std::size_t num_kept_;
  std::vector<double> values_;
  Multifrontal fronts_;
};

}  // namespace tanor::detail
