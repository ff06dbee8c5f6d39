#pragma once

#include <span>
#include <vector>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "evaluate/forces_on_points.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// A spring between inner points, with the force -(k (L - rest) + c dL/dt) u on j, u from i to j.
struct Spring {
  Index i, j;
  double stiffness, damping, rest_length;  // N/m, N s/m, m

  /// Returns true if the force is not (nearly) linear in r, so that implicit methods give it a multiplier.
  bool is_compliant() const { return rest_length > 0.0 && (stiffness > 0.0 || damping > 0.0); }
};

/// All springs of a system. Each is evaluated once.
class SpringForces {
 public:
  SpringForces() = default;
  SpringForces(const Numbering& numbering, std::vector<Spring> springs);

  bool empty() const { return springs_.empty(); }
  bool has_damping() const { return has_damping_; }

  /// Finds the force of each spring; compliant ones may be left out.
  void evaluate(const Parallel& parallel, const double* r, const double* v, bool with_compliant);
  /// Returns the forces of the last `evaluate`.
  const ForcesOnPoints& on_points() const { return on_points_; }

  /// Returns the sum of k (L - rest)^2/2, J.
  double energy(const Parallel& parallel, const double* r) const;
  /// Returns the power of damping on the moving points, W.
  double power_of_damping(const Parallel& parallel, const double* r, const double* v) const {
    return power(parallel, r, v, Part::Viscous, true);
  }
  /// Returns the power that moving supports put into the energy, W, as the force on a support does the opposite work.
  double elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v) const {
    return -power(parallel, r, v, Part::Elastic, false);
  }

  // The following is for implicit methods. A spring with a rest length is compliant: it is a rod that gives way, with a
  // multiplier tau of its own, tau + k (L - rest) + c dL/dt = 0. So Newton's iteration converges as it does with rods,
  // however stiff the spring is.

  /// Returns all springs, as pairs of points.
  std::vector<Coupling> list_couplings() const;
  std::vector<Spring> list_compliant() const;
  /// Writes the unit vectors from i to j [compliant spring][3], and tau + k (L - rest) + c dL/dt of each.
  void evaluate_compliant(const Parallel& parallel, const double* r, const double* v, const double* tau, double* units,
                          double* residuals) const;
  /// Adds scale_i (force by tau) to y_i on moving points.
  void add_compliant_forces(const Parallel& parallel, const double* units, const double* tau, const double* scale,
                            double* y) const;
  /// Evaluates dF/dr_j and dF/dv_j of the force F on j of each spring. Compliant springs are taken at given `tau`, or
  /// as all others if it is null.
  void evaluate_derivatives(const Parallel& parallel, const double* r, const double* v, const double* tau,
                            Block3* by_position, Block3* by_velocity) const;

 private:
  bool moves(Index point) const { return static_cast<std::size_t>(point) < num_moving_; }
  enum class Part { Elastic, Viscous, Both };
  static Vec3 force_of(const Spring& spring, const double* r, const double* v, Part part);
  /// Returns the power of the forces on the points that move, or on the others, W.
  double power(const Parallel& parallel, const double* r, const double* v, Part part, bool on_moving_points) const;

  std::size_t num_moving_ = 0;
  std::vector<Spring> springs_;
  std::vector<Index> compliant_;         // numbers in springs_
  std::vector<Index> compliant_number_;  // [spring] its number among those, or -1
  ForcesOnPoints on_points_;             // [spring] on its point j
  bool has_damping_ = false;
};

}  // namespace tanor::detail
