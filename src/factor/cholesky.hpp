#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include <tanor/solver_options.hpp>

#include "factor/dissection.hpp"

namespace tanor {

/// Pattern of one triangle of a symmetric n x n matrix, by columns. The entries of column j are start[j] …
/// start[j + 1] - 1, with increasing rows. The diagonal is always present.
struct TrianglePattern {
  std::vector<int> start{0};
  std::vector<int> rows;

  std::size_t size() const { return start.size() - 1; }
};

/// What the symbolic analysis found: the order of elimination and the predicted cost of a factorization.
struct SymbolicAnalysis {
  std::vector<int> permutation;  ///< [place in the elimination] -> row; empty: as it is
  Ordering ordering = Ordering::Natural;
  double factor_nonzeros = 0.0;  ///< of L
  double flops = 0.0;            ///< of one numeric factorization
  bool supernodal = false;
};

/// The points of all rows, or none where nobody knows where they are. Asked at most once.
using FindPoints = std::function<RowsInSpace()>;

/// Orders and analyzes a pattern (lower triangle). Ordering::Auto keeps the given order if that makes no fill. Else it
/// takes the one of fewest flops that it tries: AMD; cuts along axes, where AMD predicts more than 50 flops a nonzero
/// of L; METIS on the points and then on the rows, where one cut of METIS parts clearly fewer rows than those cuts do
/// and a factorization is dear beside METIS (`plan::flops_worth_metis`). Orderings that need points are METIS on the
/// rows where there are none. Throws std::bad_alloc, and std::length_error where a simplicial L has more than 2^31 - 1
/// nonzeros.
SymbolicAnalysis analyze(const TrianglePattern& lower, Ordering wanted, const FindPoints& find_points = {});

/// Factorizes L L' = S, where the rows of S already stand in the order of elimination: the symbolic analysis is made
/// once, the numeric factorization many times. This class is the door to CHOLMOD. Each object has a cholmod_common of
/// its own, so different objects may work in different threads.
class Cholesky {
 public:
  /// Simplicial factors take the upper triangle, which CHOLMOD reads without a transpose, supernodal ones the lower.
  Cholesky(TrianglePattern pattern, bool supernodal);
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;
  ~Cholesky();

  const TrianglePattern& pattern() const;
  double* values();  ///< beside pattern().rows; to be filled before `factorize`

  struct Quality {
    bool positive_definite = true;
    std::size_t weakest_column = 0;     ///< smallest pivot; the failed one where not positive definite
    double reciprocal_condition = 1.0;  ///< (min/max diagonal of L)^2: a cheap estimate from above
  };
  /// Any number of threads gives the same bits. Inside a parallel region there is one.
  [[nodiscard]] Quality factorize(int threads = 1);

  /// x := S^-1 x, [n].
  void solve(double* x, int threads = 1);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace tanor
