#pragma once

#include <Eigen/SparseCore>

#include "statics/damped_modes.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor::detail {

/// Finds the lowest damped modes of many freedoms without a basis of all moves. With p = lambda q and a small shift s >
/// 0,
///
///   Q(s) y + K mu = -(M p + (D + s M) q),   K'y = 0,   Q(s) = W + s D + s^2 M,        y' = q + s y
///
/// maps (q, p) to (y, y') = (q, p)/(lambda - s), so that the largest eigenvalues of this operator belong to the lambda
/// nearest to s. Arnoldi's method with implicit restarts (Spectra) finds some. These are deflated, as Schur vectors,
/// until nothing more lies in the circle of the wanted ones, so that multiple eigenvalues are found with their
/// multiplicity.
class DampedModeFinder {
 public:
  /// The equations must have been linearised last at the equilibrium, whose D [size(), size()] is given. `rate` is that
  /// of the fastest vibration, 1/s; |lambda| up to `zero` count as 0.
  DampedModeFinder(EquilibriumEquations& equations, Eigen::SparseMatrix<double> damping, double rate, double zero);

  struct Found {
    Outcome outcome;
    DampedModeSet modes;
  };
  /// Finds `count` modes, one of each pair. `freedoms` is that of the system, at least twice `count`.
  Found find_lowest(std::size_t count, std::size_t freedoms);

 private:
  using Vector = Eigen::VectorXd;
  class Deflated;

  [[nodiscard]] bool shift_to(double shift);
  /// Applies the operator to [q; p], with q and p in units of M^-1/2 and p divided by the shift.
  void apply(const double* from, double* to);
  /// Adds Schur vectors of more eigenvalues to `basis_`. Returns the largest |theta| of them, or infinity if none
  /// converged.
  double extend_basis(Eigen::Index wanted, double tolerance);
  void add_to_basis(Vector v);
  /// Returns the damped modes within the span of the basis, the smallest |lambda| first, one of each pair.
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

/// Finds the `count` lowest damped modes of a system with many freedoms (see DampedModeFinder). Throws InputError in a
/// build without Spectra (TANOR_SPECTRA).
DampedModeFinder::Found find_lowest_damped_modes(EquilibriumEquations& equations, Eigen::SparseMatrix<double> damping,
                                                 std::size_t count, std::size_t freedoms, double rate, double zero);

}  // namespace tanor::detail
