#pragma once

#include <span>
#include <vector>

#include "dynamics/contact_response.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/sliding_islands.hpp"
#include "schur/redundancy.hpp"

namespace tanor {

/// What contacts ask of the constrained system around them while they choose their modes: to linearize, to project, to
/// solve, always with the contacts that stick now.
class ConstrainedSystem {
 public:
  virtual ~ConstrainedSystem() = default;

  virtual ContactResponse& response() = 0;
  /// K at (t, r), and S with its factor.
  virtual Outcome linearise(double t, const double* r) = 0;
  /// v onto K'v + xi_t = 0 in the M-norm, with the linearization at (t, r); `impulses` [rows] += the multipliers, N s.
  virtual ProjectionReport project_velocities(double t, const double* r, double* v, double* impulses) = 0;
  /// w [3n] by (31) and (25), with friction by (43). `are_counted` [island]: all motions of its contacts are known, so
  /// that several sizes of friction are no several motions there; empty: of none.
  virtual Outcome accelerations(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                                const AccelerationOutput& to) = 0;

  /// lambda [rows]: the guess of the next `accelerations`, the answer of the last ones.
  virtual std::vector<double>& lambda() = 0;
  /// The accelerations around each neighbourhood [neighbourhood], m/s^2: what cancels in the last `accelerations`.
  virtual const std::vector<double>& acceleration_scales() const = 0;
  /// The same for w0 [3n] and b = phi + K'w0 [rows], whose largest number is `scale`.
  virtual const std::vector<double>& measure_accelerations(const double* w0, const double* b, double scale) = 0;

  /// K at the last linearization, and which of its rows depend on others.
  virtual const std::vector<double>& blocks() const = 0;
  virtual const Redundancy& redundancy() const = 0;
};

}  // namespace tanor
