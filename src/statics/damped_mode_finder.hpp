#pragma once

#include <Eigen/SparseCore>

#include "statics/damped_modes.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor {

/// The lowest damped modes of many freedoms, without a basis of all moves. With p = lambda q and a small shift s > 0,
///
///   Q(s) y + K mu = -(M p + (D + s M) q),   K'y = 0,   Q(s) = W + s D + s^2 M,        y' = q + s y
///
/// takes (q, p) to (y, y') = (q, p)/(lambda - s): the largest eigenvalues of that operator belong to the lambda nearest
/// to s. Arnoldi's method with implicit restarts (Spectra) finds some; what is found is deflated, as Schur vectors,
/// until nothing more lies in the circle of those that are wanted, so that equal ones are found as often as they stand.
class DampedModeFinder {
 public:
  /// Where the equations were linearised last. `rate`: of the fastest vibration, 1/s; |lambda| up to `zero` are 0.
  DampedModeFinder(EquilibriumEquations& equations, const double* r, double rate, double zero);

  struct Found {
    Outcome outcome;
    DampedModeSet modes;
  };
  /// So many, one of each pair. `freedoms`: of the system, at least twice as many.
  Found find_lowest(std::size_t count, std::size_t freedoms);

 private:
  using Vector = Eigen::VectorXd;
  class Deflated;

  [[nodiscard]] bool shift_to(double shift);
  /// [q; p] in units of M^-1/2, p over the rate that belongs to the shift.
  void apply(const double* from, double* to);
  /// Schur vectors of more eigenvalues into `basis_`; the largest |theta| of them; infinite: none
  /// converged.
  double extend_basis(Eigen::Index wanted, double tolerance);
  void add_to_basis(Vector v);
  /// Eigenvalues on the basis, the smallest |lambda| first, one of each pair, and how far from the shift all are known.
  DampedModeSet solve_on_basis();
  double find_residual(const std::complex<double>& lambda, const Eigen::VectorXcd& q);

  EquilibriumEquations& equations_;
  const Eigen::SparseMatrix<double> damping_;
  UnsymmetricKkt kkt_;
  Vector root_mass_;  // [3n]
  const double rate_, zero_;
  double shift_ = 0.0;
  Eigen::MatrixXd basis_;  // orthonormal
  std::vector<double> x_, mu_, image_;
};

}  // namespace tanor
