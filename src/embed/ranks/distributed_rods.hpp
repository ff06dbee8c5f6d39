#pragma once

#include <mpi.h>

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "embed/ranks/atoms.hpp"
#include "embed/ranks/island_exchange.hpp"
#include "embed/ranks/rod_options.hpp"

namespace tanor::embed {

/// Bonds of a program whose atoms are spread over ranks, held at their lengths: each island of them by the Constrainer
/// of its owner. Every function but those marked is collective, and answers with what is wrong, the same sentence on
/// every rank; empty: nothing is. Then no atom was touched.
class DistributedRods {
 public:
  DistributedRods(MPI_Comm world, RodOptions options);

  // ---- before a run ----

  /// Bonds found by the ranks, once or twice each, those of our types; `is_member` says which atoms may be held.
  /// Plans all islands. Lengths that were known stay. `unit_masses`: for minimisers, whose variables have no masses.
  std::string plan(const Atoms& atoms, std::vector<Bond> found, const std::vector<bool>& is_member, int threads,
                   bool unit_masses);
  bool is_planned() const { return is_planned_; }
  void forget_plan();
  /// Moves atoms onto the constraints, and their velocities if there are any.
  std::string start(const Atoms& atoms);
  /// The atoms of the ranks, or their order, have changed.
  std::string list(const Atoms& atoms) { return islands_.list(atoms.tags()); }
  /// Degrees of freedom that rods take from the atoms of a group, counted once over all ranks.
  std::size_t count_constraints(const Atoms& atoms, const std::vector<bool>& is_member);

  // ---- in a step ----

  std::string constrain_positions(const Atoms& atoms, double h);
  std::string constrain_velocities(const Atoms& atoms, double h);
  /// Tensions and the virial of this rank's islands, with velocities that are to get half_step M^-1 f yet.
  /// `force_unit`: forces of the host times this are mass times length over time squared.
  std::string measure(const Atoms& atoms, double half_step, double force_unit);
  /// Minimisation: the nearest positions; forces without what would move a constraint, with tensions and virial.
  std::string project_positions(const Atoms& atoms);
  std::string project_forces(const Atoms& atoms);

  // ---- what is known ----

  /// Largest |distance - length|/length of all rods, where the atoms are now.
  double violation(const Atoms& atoms);
  std::size_t num_bonds() const { return bonds_.size(); }  ///< of all ranks
  /// The lengths of all bonds for a restart file; not collective.
  std::vector<double> save_lengths() const;
  void restore_lengths(const double* saved);
  const std::vector<Bond>& own_bonds() const { return own_bonds_; }  ///< of this rank's islands
  std::span<const double> tensions() const { return tensions_; }     ///< [own_bonds], unit of the host's forces
  const std::array<double, 6>& virial() const { return virial_; }    ///< of own_bonds, unit of the host's energy
  struct Times {
    double all = 0.0, solver = 0.0;  // s of this rank's processor since the last `start`
    long steps = 0, iterations = 0;
  };
  const Times& times() const { return times_; }

 private:
  std::string take_bonds(const Atoms& atoms, std::vector<Bond> found, const std::vector<bool>& is_member);
  std::string find_lengths();
  std::string make_constrainer(int threads);
  std::array<double, 3> nearest(const Bond& bond, bool* is_other_image) const;
  void gather_positions(const Atoms& atoms);
  void set_box(const Box& box);
  template <class Call>
  std::string call(const Call& call);
  std::string finish_positions(const Atoms& atoms, const std::string& trouble);
  void take_reactions(const ConstraintReport& report, double force_unit);
  std::string describe(const ConstraintReport& report) const;

  RodOptions options_;
  IslandExchange islands_;
  std::vector<Bond> bonds_, own_bonds_;
  std::vector<bool> is_redundant_;  // [own_bonds]
  Box box_;
  bool joins_nearest_images_ = false;  // the flags of the atoms' images do not say which
  bool has_unit_masses_ = false, is_planned_ = false;
  std::optional<Constrainer> constrainer_;        // none on a rank that owns nothing
  std::vector<double> masses_, r_, old_, v_, f_;  // in the order of points; old_: on the constraints
  std::vector<double> tensions_;
  std::array<double, 6> virial_{};
  Times times_;
};

}  // namespace tanor::embed
