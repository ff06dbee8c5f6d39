#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <tanor/solver_options.hpp>

#include "factor/dissection.hpp"

namespace tanor::detail {

/// Pattern of one triangle of a symmetric n x n matrix, by columns. The entries of column j are start[j] …
/// start[j + 1] - 1, with increasing rows. The diagonal is always present.
struct TrianglePattern {
  std::vector<int> start{0};
  std::vector<int> rows;

  std::size_t size() const { return start.size() - 1; }
};

/// Result of the symbolic analysis: the order of elimination and the predicted cost of a factorization.
struct SymbolicAnalysis {
  std::vector<int> permutation;  ///< [place in the elimination] -> row; empty if the order stays
  Ordering ordering = Ordering::Natural;
  double factor_nonzeros = 0.0;  ///< nonzeros of L
  double flops = 0.0;            ///< flops of one numeric factorization
  bool supernodal = false;
};

/// Returns the points of all rows, or none if their positions are unknown. It is called at most once.
using FindPoints = std::function<RowsInSpace()>;

/// Orders and analyzes a pattern (lower triangle). Ordering::Auto keeps the given order if that makes no fill.
/// Otherwise it takes the one of fewest flops among those that it tries. It tries AMD, then cuts along axes if AMD
/// predicts more than 50 flops a nonzero of L. It tries METIS on the points, and then on the rows, if one cut of METIS
/// parts clearly fewer rows than those cuts do and a factorization costs much compared with METIS
/// (`plan::flops_worth_metis`). Of many rows (`plan::rows_worth_axes_first`) whose given order makes so many flops it
/// tries AMD after the cuts along axes, and only if that one cut of METIS is clearly better.
/// Without points, orderings that need them are replaced by METIS on the rows. Throws std::bad_alloc, and
/// std::length_error if a simplicial L has more than 2^31 - 1 nonzeros.
SymbolicAnalysis analyze(const TrianglePattern& lower, Ordering wanted, const FindPoints& find_points = {});

/// Returns an order of elimination, [place] -> row, of a pattern (lower triangle) that keeps some rows for the end, in
/// the order that they have. The other rows are ordered by `wanted` as if the kept ones were not there.
std::vector<int> order_keeping(const TrianglePattern& lower, std::span<const char> is_kept, Ordering wanted);

/// Counts the negative eigenvalues of a symmetric matrix by the signs of the pivots of L D L', in the order in which
/// its rows stand (Sylvester). `upper` is its upper triangle, with `values` beside its rows. Returns nothing if a pivot
/// vanishes, because the matrix is singular or needs another order.
std::optional<std::size_t> count_negative_eigenvalues(const TrianglePattern& upper, std::vector<double> values);

/// Factorizes L L' = S. The rows of S already stand in the order of elimination. The symbolic analysis is made once,
/// the numeric factorization many times. Different objects may work in different threads.
class Cholesky {
 public:
  struct Quality {
    bool positive_definite = true;
    std::size_t weakest_row = 0;        ///< row of the smallest pivot, or of the failed one
    double reciprocal_condition = 1.0;  ///< (min/max diagonal of L)^2, a cheap estimate from above
  };

  /// A supernodal factor takes the lower triangle. Any other one takes the upper triangle, which CHOLMOD reads without
  /// a transpose, and is in closed form where that serves. If `by_cholmod` is true, CHOLMOD factorizes and solves
  /// alone.
  Cholesky(TrianglePattern pattern, bool supernodal, bool by_cholmod = false);

  Factorization kind() const { return method_->kind; }
  const TrianglePattern& pattern() const { return method_->pattern; }
  double* values() { return method_->values.data(); }  ///< beside pattern().rows; to be filled before `factorize`

  /// Factorizes the values. Any number of threads gives the same bits. Inside a parallel region there is one thread.
  [[nodiscard]] Quality factorize(int threads = 1) { return method_->factorize(threads); }

  /// Solves in place: x := S^-1 x, [n].
  void solve(double* x, int threads = 1) { method_->solve(x, threads); }

  /// True if several threads take less time than one for a factorization, or for a solve.
  bool factorizes_by_threads() const { return method_->factorizes_by_threads(); }
  bool solves_by_threads() const { return method_->solves_by_threads(); }

  /// One way to factorize and to solve.
  struct Method {
    TrianglePattern pattern;
    std::vector<double> values;
    Factorization kind;

    Method(TrianglePattern given, Factorization by)
        : pattern(std::move(given)), values(pattern.rows.size()), kind(by) {}
    virtual ~Method() = default;
    virtual Quality factorize(int threads) = 0;
    virtual void solve(double* x, int threads) = 0;
    virtual bool factorizes_by_threads() const { return false; }
    virtual bool solves_by_threads() const { return false; }
  };

 private:
  std::unique_ptr<Method> method_;
};

}  // namespace tanor::detail
