#pragma once

#include <span>
#include <vector>

#include "dynamics/contact_response.hpp"
#include "dynamics/dependences.hpp"
#include "dynamics/mechanics.hpp"
#include "schur/gram_solver.hpp"

namespace tanor::detail {

/// Serves the contacts while they choose their modes: it linearizes, projects and solves the constrained system, always
/// with the contacts that stick at present.
class ConstrainedSystem {
 public:
  virtual ~ConstrainedSystem() = default;

  virtual ContactResponse& response() = 0;
  /// S of all rows, in which the rows of contacts may be made compliant.
  virtual GramSolver& gram() = 0;
  /// Evaluates K at (t, r) and factorizes S.
  virtual Outcome linearise(double t, const double* r) = 0;
  /// Projects v onto K'v + xi_t = 0 in the M-norm, with the linearization at (t, r). Adds the multipliers, N s, to
  /// `impulses` [rows].
  virtual ProjectionReport project_velocities(double t, const double* r, double* v, double* impulses) = 0;
  /// Computes w [3n] by (31) and (25), with friction by (43). `are_counted` [island] marks islands where all motions of
  /// the contacts are known, so that several magnitudes of friction are not several motions. It is empty if there are
  /// none.
  virtual Outcome accelerations(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                                const AccelerationOutput& to) = 0;

  /// The multipliers lambda [rows], from which `accelerations` searches the fixed point (43), and which it replaces.
  virtual std::vector<double>& lambda() = 0;
  /// The largest terms that cancelled in those accelerations around each neighbourhood [neighbourhood], m/s^2.
  virtual const std::vector<double>& acceleration_scales() const = 0;
  /// Measures the same for w0 [3n] and b = phi + K'w0 [rows]. `scale` is their largest number.
  virtual const std::vector<double>& measure_accelerations(const double* w0, const double* b, double scale) = 0;

  /// K at the last linearization, and the rows of it that depend on others.
  virtual const std::vector<double>& blocks() const = 0;
  virtual const Dependences& redundancy() const = 0;
  /// Replaces lambda [rows] by the multipliers of least norm with the same reactions at r, where K was evaluated last.
  virtual void minimize_multiplier_norm(const double* r, double* lambda) = 0;
};

}  // namespace tanor::detail
