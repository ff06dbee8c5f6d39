#pragma once

#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/force_derivatives.hpp"
#include "evaluate/forces_on_points.hpp"
#include "evaluate/potential_family.hpp"

namespace tanor::detail {

/// Forces of tuples of points that have an energy: bonds, angles, torsions, and a user's own.
///
/// The stiffness of smooth pair forces, whose forces are found elsewhere (`PairField`), is known here too.
class EnergyForces {
 public:
  EnergyForces() = default;
  /// `of_pairs` are pair forces as tuples, of which the stiffness alone is wanted.
  EnergyForces(const Numbering& numbering, std::vector<EnergyGroup> groups, std::vector<EnergyGroup> of_pairs);

  bool empty() const { return families_.empty(); }
  bool depends_on_time() const { return depends_on_time_; }

  /// Evaluates the forces and the explicit dU/dt.
  void evaluate(const Parallel& parallel, double t, const double* r);
  /// Returns the forces of the last `evaluate`.
  const ForcesOnPoints& on_points() const { return on_points_; }
  /// Writes the force of all tuples on each point at the last `evaluate`, N [3n].
  void write_forces(double* f) const;

  /// Returns the sum of all U at t and r, J.
  double energy(const Parallel& parallel, double t, const double* r);
  /// Returns the explicit dU/dt of all tuples, W, at the t and r of the last `evaluate`.
  double explicit_rate(const Parallel& parallel) const;
  /// Returns the power that moving supports put in, W, at the (t, r) of the last `evaluate`.
  double power_of_supports(const Parallel& parallel, const double* v) const;
  /// Names a tuple whose energy is undefined at t and r, and why. Returns an empty string if there is none.
  std::string find_undefined(const Parallel& parallel, double t, const double* r) const;

  std::size_t num_influences() const { return num_influences_; }
  void append_influences(std::vector<Influence>* list) const;
  /// Evaluates -d2U/dr_i dr_j'. It is added to the blocks of points where i = j; the others are the first influences.
  void add_derivatives(const Parallel& parallel, double t, const double* r, const ForceDerivatives& to);

 private:
  template <class Visit>
  void for_each_stiff_family(const Visit& visit) const;
  void list_slots();
  void list_own_blocks();
  bool moves(Index point) const { return static_cast<std::size_t>(point) < num_moving_; }

  std::size_t num_points_ = 0, num_moving_ = 0;
  std::vector<PotentialFamily> families_, pair_families_;
  std::vector<Index> points_;             // [slot] its point
  ForcesOnPoints on_points_;              // family by family, point by point of all its tuples
  std::vector<double> energies_, rates_;  // [tuple] U, and its explicit dU/dt at the last `evaluate`
  std::vector<Block3> stiffness_;         // [tuple][p][p]; made by the first call that needs it
  Groups<Index> own_blocks_;              // in stiffness_
  std::size_t num_blocks_ = 0, num_influences_ = 0;
  bool depends_on_time_ = false;
};

}  // namespace tanor::detail
