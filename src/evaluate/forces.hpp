#pragma once

#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/block3.hpp"
#include "base/parallel.hpp"
#include "evaluate/formula_passages.hpp"
#include "evaluate/pair_field.hpp"
#include "evaluate/potential_family.hpp"
#include "kinds/tables.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// Entries that each belong to a point, side by side point by point; those of one point in the order they came in.
template <class Entry>
class ByPoint {
 public:
  ByPoint() = default;
  ByPoint(std::size_t num_points, const std::vector<std::pair<Index, Entry>>& entries) {
    if (entries.empty()) return;
    start_.assign(num_points + 1, 0);
    for (const auto& [point, entry] : entries) ++start_[point + 1];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    entries_.resize(entries.size());
    std::vector<Index> next(start_.begin(), start_.end() - 1);
    for (const auto& [point, entry] : entries) entries_[next[point]++] = entry;
  }

  bool empty() const { return entries_.empty(); }
  std::span<const Entry> operator[](std::size_t point) const {
    if (empty()) return {};
    return {entries_.begin() + start_[point], entries_.begin() + start_[point + 1]};
  }

 private:
  std::vector<Index> start_;  // [point], one more
  std::vector<Entry> entries_;
};

/// The active forces f(r, v, t) of a system, in the inner order.
///
/// A spring is evaluated once; then each point gathers what acts on it in a fixed order, so any number of threads gives
/// the same bits.
class Forces {
 public:
  Forces(const System& system, const Numbering& numbering);

  /// Some force has no potential: drag, damping, or a force that depends on time.
  bool has_work() const {
    return !drags_.empty() || has_damping_ || forces_depend_on_time_ || potentials_depend_on_time_ ||
           !formulas_.empty();
  }
  bool depends_on_velocity() const { return !drags_.empty() || has_damping_ || formulas_depend_on_velocity_; }
  bool has_springs() const { return !springs_.empty(); }
  bool has_pairs() const { return !pairs_.empty(); }
  bool has_potentials() const { return !potentials_.empty(); }
  bool has_formulas() const { return !formulas_.empty(); }

  /// M^-1 f of every moving point, where gravity alone acts.
  std::optional<Vec3> uniform_acceleration() const {
    const bool others = has_springs() || has_pairs() || has_potentials() || !given_forces_.empty() || !drags_.empty() ||
                        !formulas_.empty();
    return others ? std::nullopt : std::optional(gravity_);
  }

  /// f [3n], N. Compliant springs may be left out, see below.
  enum class Which { All, WithoutCompliant };
  void evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f,
                Which which = Which::All);

  /// The largest force on a moving point by gravity, or by one other entry's spring, tuple, formula or given force
  /// alone, at the last `evaluate`; of pair forces what they do to a point together. N.
  double largest_single(const Parallel& parallel, const double* r);

  /// What `power` and `power_of_potentials` read of `evaluate`, at the same place: less than all forces.
  void evaluate_powers(const Parallel& parallel, double t, const double* r, const double* v);

  /// Forces that may act between the looks of a step alone: pairs, formulas and energies with narrow places.
  bool may_be_passed() const { return has_pairs() || !formula_passages_.empty(); }
  /// The part of a step to make instead of one that passes such forces unseen; 1: it passes none.
  double find_passage(const Parallel& parallel, PointPath* path);

  // What implicit methods see. A spring with a rest length is compliant: a rod that gives way, with a multiplier tau of
  // its own, tau + k (L - rest) + c dL/dt = 0, so that Newton's iteration converges as it does with rods, however
  // stiff.

  struct CompliantSpring {
    Index i, j;
    double stiffness, damping;
  };
  std::vector<CompliantSpring> list_compliant_springs() const;
  /// Unit vectors from i to j [compliant spring][3], and tau + k (L - rest) + c dL/dt of each.
  void evaluate_compliant_springs(const Parallel& parallel, const double* r, const double* v, const double* tau,
                                  double* units, double* residuals) const;
  /// y_i += scale_i (force by tau) on moving points.
  void add_compliant_forces(const Parallel& parallel, const double* units, const double* tau, const double* scale,
                            double* y) const;

  /// All springs, as pairs of points.
  std::vector<Coupling> list_couplings() const;
  /// Points of a tuple with an energy or a formula, on each other: one for each ordered pair of them.
  std::vector<Influence> list_influences() const;
  /// What `evaluate_derivatives` says: of points [moving point], of couplings in the order of `list_couplings`, of
  /// influences in that of `list_influences`.
  struct Derivatives {
    Block3 *point_positions, *point_velocities;        ///< df_i/dr_i and df_i/dv_i without those of couplings
    Block3 *coupling_positions, *coupling_velocities;  ///< of the force on j in r_j and v_j, see Coupling
    Block3* influence_positions;                       ///< of the force on a point in the place of another one
    Block3* influence_velocities = nullptr;            ///< and in its velocity; null: not wanted
  };
  /// df/dr and df/dv at (t, r, v) of springs (compliant ones at given tau; null: as all others), drag, formulas,
  /// energies and pair forces with a smooth law; those of pair forces with a cutoff are left out.
  void evaluate_derivatives(const Parallel& parallel, double t, const double* r, const double* v, const double* tau,
                            const Derivatives& to);

  /// Potential energy of gravity, constant forces, springs, pairs and tuples at t, J. Supports take part as far as
  /// springs hold them moving points push them: what two supports do to each other by pair forces is a load of theirs
  /// (f), no energy.
  double potential(const Parallel& parallel, double t, const double* r);
  /// Power of the forces without potential on the moving points, W, at the (t, r, v) of the last `evaluate`.
  double power(const Parallel& parallel, const double* r, const double* v) const;
  /// The explicit dU/dt of all energies, W, at the t and r of the last `evaluate`.
  double power_of_potentials(const Parallel& parallel) const;
  /// What all tuples do to each point at the last `evaluate`, N [3n].
  void write_potential_forces(double* f) const;
  /// Names a tuple whose energy ends at t and r, and why; empty: there is none.
  std::string find_undefined(const Parallel& parallel, double t, const double* r) const;
  /// Power that moving supports put in through springs, pairs and tuples, W, at the (t, r, v) of the last `evaluate`.
  double elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v);

 private:
  struct Spring {
    Index i, j;
    double stiffness, damping, rest_length;
    Index compliant;  // number among the compliant ones, -1: the force is (nearly) linear in r
  };
  struct DragNumbers {
    double linear, quadratic;
  };
  struct FormulaGroup {
    ForceKernel kernel;
    std::vector<Index> points;  // [member][p]
    std::size_t first_slot;

    std::size_t points_per_member() const { return static_cast<std::size_t>(kernel.num_points); }
    std::size_t size() const { return points.size() / points_per_member(); }
  };
  void add_formula(const FormulaForce& formula, const Numbering& numbering,
                   std::vector<std::pair<Index, Index>>* slots);
  void evaluate_formulas(const Parallel& parallel, double t, const double* r, const double* v);
  void evaluate_formula_derivatives(const Parallel& parallel, double t, const double* r, const double* v,
                                    const Derivatives& to) const;
  struct Member;
  void add_member_derivatives(const FormulaGroup& group, const Member& member, const Derivatives& to) const;
  void add_spring(const Numbering& numbering, const Spring& spring, std::vector<std::pair<Index, Index>>* ends);
  void add_potential(EnergyGroup group, const Numbering& numbering, std::vector<std::pair<Index, Index>>* slots);
  void list_own_blocks();
  template <class Visit>
  void for_each_stiff_family(const Visit& visit) const;
  void evaluate_potentials(const Parallel& parallel, double t, const double* r);
  void add_potential_derivatives(const Parallel& parallel, double t, const double* r, const Derivatives& to);
  std::vector<Index> list_moving(std::span<const Index> points) const;
  bool moves(Index point) const { return static_cast<std::size_t>(point) < num_moving_; }
  Vec3 spring_force(const Spring& spring, const double* r, const double* v, bool elastic, bool viscous) const;

  std::size_t num_points_ = 0, num_moving_ = 0;
  std::vector<double> mass_;  // [moving point], kg
  Vec3 gravity_{};
  VectorTable<AsGiven> given_;
  std::vector<char> given_is_constant_;
  ByPoint<Index> given_forces_;  // slots in given_
  ByPoint<DragNumbers> drags_;
  std::vector<Spring> springs_;
  std::vector<double> spring_force_;          // [spring] on its point j
  std::vector<Index> compliant_springs_;      // numbers in springs_
  ByPoint<Index> spring_ends_;                // k, or ~k where the point is the spring's point i
  std::vector<PairField> pairs_;              // each keeps what belongs to the positions it saw last
  std::vector<PairField> pairs_of_supports_;  // of both ends; on supports that stand it is found once
  bool has_damping_ = false, forces_depend_on_time_ = false;
  std::vector<FormulaGroup> formulas_;
  std::vector<std::unique_ptr<FormulaPassages>> formula_passages_;
  std::vector<double> formula_force_;  // group by group, 3 numbers a point
  ByPoint<Index> formula_forces_;      // slots in formula_force_
  bool formulas_depend_on_velocity_ = false;
  std::vector<PotentialFamily> potentials_;
  ByPoint<Index> potential_forces_;             // slots in potential_force_
  std::vector<Index> potential_points_;         // [slot] its point
  std::vector<double> potential_force_;         // family by family, tuple by tuple, 3 numbers a point
  std::vector<double> energies_, rates_;        // [tuple] U, and its explicit dU/dt at the last `evaluate`
  std::vector<PotentialFamily> pair_energies_;  // of smooth pair forces: their stiffness
  std::vector<Block3> stiffness_;               // [tuple][p][p]; made by the first call that wants it
  ByPoint<Index> own_blocks_;                   // in stiffness_
  std::size_t num_stiffness_blocks_ = 0, num_energy_influences_ = 0;
  bool potentials_depend_on_time_ = false;
};

}  // namespace tanor
