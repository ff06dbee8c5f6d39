#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <vector>

namespace tanor::detail {

/// Pattern of a square sparse matrix by columns. The entries of column j are start[j] … start[j + 1] - 1, rows
/// increasing.
struct SquarePattern {
  std::vector<int> start{0};
  std::vector<int> rows;

  std::size_t size() const { return start.size() - 1; }
};

/// Factorizes P A Q = L U of a general square matrix, T = double or std::complex<double>. The symbolic analysis is made
/// once, the numeric factorization many times. This class is the interface to KLU.
///
/// The first factorization chooses the pivots. The next ones keep them as long as they serve, and then allocate
/// nothing. If a pivot is too small, all are chosen anew.
template <class T>
class SparseLu {
 public:
  /// Throws std::bad_alloc.
  explicit SparseLu(SquarePattern pattern);
  ~SparseLu();

  const SquarePattern& pattern() const { return pattern_; }
  T* values() { return values_.data(); }  ///< beside pattern().rows; to be filled before `factorize`

  /// Factorizes the values. Returns false, without a factor, if A is singular or holds numbers that are not finite.
  [[nodiscard]] bool factorize();
  /// Forgets the pivots, so that the next factorization chooses them anew.
  void forget_pivots();
  /// Returns true if the last factorization succeeded and its pivots were not forgotten.
  bool has_factor() const;

  /// Solves in place: x := A^-1 x, [n].
  void solve(T* x);

  /// Returns the number of factorizations so far that chose their pivots.
  std::size_t num_pivotings() const { return num_pivotings_; }

 private:
  struct Klu;
  bool factorize_anew();
  bool factorize_again();

  SquarePattern pattern_;
  std::vector<T> values_;
  std::unique_ptr<Klu> klu_;
  std::size_t num_pivotings_ = 0;
};

extern template class SparseLu<double>;
extern template class SparseLu<std::complex<double>>;

}  // namespace tanor::detail
