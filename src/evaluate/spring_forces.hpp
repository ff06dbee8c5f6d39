#pragma once

#include <span>
#include <vector>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "evaluate/forces_on_points.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// A spring between inner points, with the force -(k (L - rest) + c dL/dt) u on j, u from i to j.
struct Spring {
  Index i, j;
  double stiffness, damping, rest_length;  // N/m, N s/m, m

  /// Its force is not (nearly) linear in r, so implicit methods give it a multiplier.
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
  /// The forces of the last `evaluate`.
  const ForcesOnPoints& on_points() const { return on_points_; }

  /// sum k (L - rest)^2/2, J.
  double energy(const Parallel& parallel, const double* r) const;
  /// Of damping, on the moving points, W.
  double power_of_damping(const Parallel& parallel, const double* r, const double* v) const;
  /// That moving supports put into the energy, W.
  double elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v) const;

  // What implicit methods see. A spring with a rest length is compliant: a rod that gives way, with a multiplier tau of
  // its own, tau + k (L - rest) + c dL/dt = 0, so that Newton's iteration converges as it does with rods, however
  // stiff.

  /// All springs, as pairs of points.
  std::vector<Coupling> list_couplings() const;
  std::vector<Spring> list_compliant() const;
  /// Unit vectors from i to j [compliant spring][3], and tau + k (L - rest) + c dL/dt of each.
  void evaluate_compliant(const Parallel& parallel, const double* r, const double* v, const double* tau, double* units,
                          double* residuals) const;
  /// y_i += scale_i (force by tau) on moving points.
  void add_compliant_forces(const Parallel& parallel, const double* units, const double* tau, const double* scale,
                            double* y) const;
  /// dF/dr_j and dF/dv_j of the force F on j of each spring, compliant ones at given tau; null: as all others.
  void evaluate_derivatives(const Parallel& parallel, const double* r, const double* v, const double* tau,
                            Block3* by_position, Block3* by_velocity) const;

 private:
  bool moves(Index point) const { return static_cast<std::size_t>(point) < num_moving_; }
  enum class Part { Elastic, Viscous, Both };
  static Vec3 force_of(const Spring& spring, const double* r, const double* v, Part part);

  std::size_t num_moving_ = 0;
  std::vector<Spring> springs_;
  std::vector<Index> compliant_;         // numbers in springs_
  std::vector<Index> compliant_number_;  // [spring] its number among those, or -1
  ForcesOnPoints on_points_;             // [spring] on its point j
  bool has_damping_ = false;
};

}  // namespace tanor
