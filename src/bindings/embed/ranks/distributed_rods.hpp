#pragma once

#include <mpi.h>

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "embed/ranks/atoms.hpp"
#include "embed/ranks/cpu_clock.hpp"
#include "embed/ranks/island_exchange.hpp"
#include "embed/ranks/rod_options.hpp"

namespace tanor::embed {

/// Bonds that are held at their lengths in a program whose atoms are spread over ranks. Each island is held by the
/// Constrainer of its owner. Every function but those marked is collective, and returns what is wrong, the same
/// sentence on every rank, or an empty text. A call that went wrong has touched no atom.
class DistributedRods {
 public:
  DistributedRods(MPI_Comm world, RodOptions options);

  // ---- before a run ----

  /// Plans all islands. `found` are bonds found by the ranks, once or twice each; those of our types count. `is_member`
  /// says which atoms may be held. Lengths that were known stay. `unit_masses` is for minimisers, whose variables have
  /// no masses.
  std::string plan(const Atoms& atoms, const std::vector<Bond>& found, const std::vector<bool>& is_member, int threads,
                   bool unit_masses);
  bool is_planned() const { return is_planned_; }
  void forget_plan();
  /// True if these bonds, found as for `plan`, are others than those of the last plan.
  bool differ_from(const std::vector<Bond>& found) const;
  /// Returns a type of ours that no bond has.
  std::string find_missing_type() const;
  /// Moves atoms onto the constraints, then projects their velocities if there are any. Atoms may have moved if this
  /// went wrong.
  std::string start(const Atoms& atoms);
  /// Lists the atoms anew, after those of the ranks, or their order, have changed.
  std::string list(const Atoms& atoms);
  /// Returns the degrees of freedom that rods take from the atoms of a group, counted once over all ranks.
  std::size_t count_constraints(const std::vector<bool>& is_member);

  // ---- in a step ----

  std::string constrain_positions(const Atoms& atoms, double h);
  std::string constrain_velocities(const Atoms& atoms, double h);
  /// Computes tensions and the virial of this rank's islands, with velocities that will still get half_step M^-1 f.
  /// `force_unit` is such that forces of the host times it are mass times length over time squared. If `with_stress`,
  /// each rod adds half of its virial to the stress of both atoms.
  std::string measure(const Atoms& atoms, double half_step, double force_unit, bool with_stress);
  /// For a minimisation: projects to the nearest positions, and removes from forces what would move a constraint, with
  /// the results of `measure`.
  std::string project_positions(const Atoms& atoms);
  std::string project_forces(const Atoms& atoms, bool with_stress);

  // ---- what is known ----

  /// Returns the largest |distance - length|/length of all rods, where the atoms are now.
  double violation(const Atoms& atoms);
  std::size_t num_bonds() const { return bonds_.size(); }  ///< bonds of all ranks
  /// Returns the lengths of all bonds for a restart file. Not collective.
  std::vector<double> save_lengths() const;
  void restore_lengths(const double* saved);
  const std::vector<Bond>& own_bonds() const { return own_bonds_; }  ///< bonds of this rank's islands
  std::span<const double> tensions() const { return tensions_; }     ///< [own_bonds], unit of the host's forces
  const std::array<double, 6>& virial() const { return virial_; }    ///< virial of own_bonds, unit of the host's energy
  struct Times {
    double all = 0.0, solver = 0.0;  // s of this rank's processor
    long steps = 0, iterations = 0;
  };
  const Times& times() const { return times_; }  ///< since the last `reset_times`
  void reset_times() { times_ = {}; }
  /// Returns a clock for what the caller does for us in a step. Functions of a step count by themselves.
  CpuClock clock() { return CpuClock(&times_.all); }

 private:
  std::string take_bonds(const Atoms& atoms, const std::vector<Bond>& found, const std::vector<bool>& is_member);
  std::string find_lengths();
  std::string make_constrainer(int threads);
  std::array<double, 3> nearest(const Bond& bond, bool* is_other_image) const;
  void gather_positions(const Atoms& atoms);
  void set_box(const Box& box);
  template <class Call>
  std::string call(const Call& call);
  std::string finish_positions(const Atoms& atoms, double h, double rate, const std::string& trouble);
  std::string solve(const Atoms& atoms, double force_unit, bool with_stress, std::span<double> accelerations);
  std::string describe(const ConstraintReport& report) const;

  RodOptions options_;
  IslandExchange islands_;
  std::vector<Bond> bonds_, own_bonds_;
  std::vector<bool> is_redundant_;  // [own_bonds]
  std::uint64_t mark_ = 0;          // mark of the bonds that `plan` was given
  Box box_;
  bool joins_nearest_images_ = false;  // the flags of the atoms' images do not say which images bonds join
  bool has_unit_masses_ = false, is_planned_ = false;
  std::optional<Constrainer> constrainer_;  // none on a rank that owns nothing
  /// Arrays in the order of points.
  struct PointNumbers {
    std::vector<double> masses;
    std::vector<double> r, old;  // positions, and those on the constraints
    std::vector<double> move;    // change by the constraints, 0 between calls
    std::vector<double> v, f;
    std::vector<double> stress;  // nine numbers each
  } at_;
  std::vector<double> tensions_;  // [own_bonds]
  std::array<double, 6> virial_{};
  Times times_;
};

}  // namespace tanor::embed
