#pragma once

#include <Eigen/SparseCore>
#include <memory>
#include <vector>

#include "factor/sparse_lu.hpp"
#include "statics/equilibrium_equations.hpp"

namespace tanor::detail {

/// LU factorization of the whole matrix, for forces that may have no potential, so that A need not be symmetric:
///
///   [ A  K ] [ x  ]   [ b ]
///   [ K' 0 ] [ mu ] = [ c ],   A = W + c D + s M
///
/// A tiny compliance in the zero block lets rows depend on each other; iterative refinement removes its effect.
class UnsymmetricKkt {
 public:
  explicit UnsymmetricKkt(const EquilibriumEquations& equations) : equations_(equations), model_(equations.model()) {}

  /// A damping matrix D, whose entries lie within the pattern of W.
  struct Damped {
    const Eigen::SparseMatrix<double>* damping = nullptr;
    double rate = 0.0;  // c, 1/s
  };
  /// Factorizes with W and K as they were linearised last; s in 1/s^2. Returns false if the matrix is singular.
  [[nodiscard]] bool factorize(double shift) { return factorize(shift, {}); }
  [[nodiscard]] bool factorize(double shift, const Damped& damped);
  /// Solves in place: x [size()] and mu [num_rows()] hold b and c on entry and the solution on return.
  void solve(std::vector<double>* x, std::vector<double>* mu);

 private:
  template <class Visit>
  void for_each_term(const Visit& visit) const;
  void make_pattern();

  const EquilibriumEquations& equations_;
  const Model& model_;
  std::size_t pattern_version_ = 0;  // of W, for which the factor was made
  std::unique_ptr<SparseLu<double>> factor_;
  std::vector<int> slots_;  // [term] the entry that it is added to
  double shift_ = 0.0;
  Damped damped_;
};

}  // namespace tanor::detail
