#pragma once

#include <memory>
#include <vector>

#include <tanor/ranks.hpp>

#include "dynamics/motion_series.hpp"
#include "dynamics/workspace.hpp"
#include "ranks/agreement.hpp"

namespace tanor::detail {

/// The contribution of a rank to the energies and powers of all, where constraints and forces reach from rank to rank.
/// Each energy is counted by one rank, each point's power by its owner.
class CutEnergies {
 public:
  CutEnergies(Workspace& work, const Part& part, Agreement& agreement);

  /// True if power is not identically 0 on this rank.
  bool has_work() const { return is_rheonomic_ || work_.forces.has_work(); }
  Energy energy(double t, const double* r, const double* v);
  double potential(double t, const double* r);
  /// Returns the power of the reactions on this rank's own points, from M^-1 eta [3n]. The reactions carry what
  /// supports do from rank to rank, also to ranks without moving supports.
  double power_of_reactions(const double* accelerations, const double* v) const;
  /// Returns the power where free accelerations were evaluated last. `of_constraints` is what constraints put in.
  Power power(const Kinematics& at, double of_constraints);
  /// Returns the power where the first `terms` of the last series after r_0 place the points.
  Power power_along(const Kinematics& at, int terms, MotionSeries& series);
  void clear_guests(double* points) const;

 private:
  /// Pair forces without a cutoff between own points and guests.
  struct PairsWithGuests {
    std::size_t entry;    // among the pair forces of the system
    PairField among_own;  // those between own points, which no other rank has
  };
  void add_pairs(std::size_t entry, const PairForces& pairs);
  double potential_counted_elsewhere(double t, const double* r);

  Workspace& work_;
  const Model& model_;
  std::vector<std::size_t> guests_;            // inner
  std::unique_ptr<Forces> counted_elsewhere_;  // forces whose energies other ranks count; null if there are none
  std::vector<PairsWithGuests> pairs_with_guests_;
  bool is_rheonomic_;                                // on some rank
  std::vector<std::size_t> rows_counted_elsewhere_;  // inner
  std::vector<double> own_v_, points_;               // [3n] scratch
};

}  // namespace tanor::detail
