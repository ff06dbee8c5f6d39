#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/angle_passages.hpp"
#include "evaluate/energy_forces.hpp"
#include "evaluate/formula_forces.hpp"
#include "evaluate/formula_passages.hpp"
#include "evaluate/given_forces.hpp"
#include "evaluate/pair_field.hpp"
#include "evaluate/pairs_beyond.hpp"
#include "evaluate/spring_forces.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The active forces f(r, v, t) of a system, in the inner order.
///
/// Each sort of force knows its own part; here they are added up, point by point in a fixed order, so any number of
/// threads gives the same bits.
class Forces {
 public:
  Forces(const System& system, const Numbering& numbering);

  /// Some force has no potential: drag, damping, or a force that depends on time.
  bool has_work() const {
    return !drags_.empty() || springs_.has_damping() || given_.depend_on_time() || energies_.depends_on_time() ||
           !formulas_.empty();
  }
  bool depends_on_velocity() const {
    return !drags_.empty() || springs_.has_damping() || formulas_.depends_on_velocity();
  }
  bool has_pairs() const { return !pairs_.empty() || !pairs_beyond_.empty(); }
  /// Adds pair forces that reach to other processes: calls that need them are collective from here on.
  void add_pairs_beyond(std::unique_ptr<PairsBeyond> pairs) { pairs_beyond_.push_back(std::move(pairs)); }
  bool has_springs() const { return !springs_.empty(); }
  bool has_energies() const { return !energies_.empty(); }
  bool has_formulas() const { return !formulas_.empty(); }
  const SpringForces& springs() const { return springs_; }
  const EnergyForces& energies() const { return energies_; }

  /// M^-1 f of every moving point, where gravity alone acts.
  std::optional<Vec3> uniform_acceleration() const {
    const bool others =
        has_springs() || has_pairs() || has_energies() || !given_.empty() || !drags_.empty() || has_formulas();
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

  /// Forces that may act between the looks of a step alone: pairs, formulas and energies with narrow places, angles
  /// at which laws end.
  bool may_be_passed() const { return act_briefly() || !angle_passages_.empty(); }
  /// The same but for the angles.
  bool act_briefly() const { return has_pairs() || !formula_passages_.empty(); }
  /// The part of a step to make instead of one that passes such forces unseen; 1: it passes none.
  double find_passage(const Parallel& parallel, PointPath* path);
  /// Those of moving points, as the system lists them.
  std::span<const PairField> pairs() const { return pairs_; }

  /// All springs, as pairs of points.
  std::vector<Coupling> list_couplings() const { return springs_.list_couplings(); }
  /// Points of a tuple with an energy or a formula, on each other: one for each ordered pair of them.
  std::vector<Influence> list_influences() const;
  /// df/dr and df/dv at (t, r, v) of springs (compliant ones at given tau; null: as all others), drag, formulas,
  /// energies and pair forces of few points with a smooth law; those of other pair forces are left out.
  void evaluate_derivatives(const Parallel& parallel, double t, const double* r, const double* v, const double* tau,
                            const ForceDerivatives& to);

  /// PairField::for_each_stiffness of pair forces that `evaluate_derivatives` leaves out.
  void for_each_pair_stiffness(const Parallel& parallel, const double* r, const PairField::VisitStiffness& visit);

  /// Potential energy of gravity, constant forces, springs, pairs and tuples at t, J. Supports take part as far as
  /// springs hold them moving points push them: what two supports do to each other by pair forces is a load of theirs
  /// (f), no energy.
  double potential(const Parallel& parallel, double t, const double* r);
  /// Power of the forces without potential on the moving points, W, at the (t, r, v) of the last `evaluate`.
  double power(const Parallel& parallel, const double* r, const double* v) const;
  /// Power that moving supports put in through springs, pairs and tuples, W, at the (t, r, v) of the last `evaluate`.
  double elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v);

 private:
  class Reader;

  std::size_t num_points_ = 0, num_moving_ = 0;
  std::vector<double> mass_;  // [moving point], kg
  Vec3 gravity_{};
  GivenForces given_;
  ByPoint<DragNumbers> drags_;
  SpringForces springs_;
  FormulaForces formulas_;
  EnergyForces energies_;
  std::vector<PairField> pairs_;                            // each keeps what belongs to the positions it saw last
  std::vector<PairField> pairs_of_supports_;                // of both ends; on supports that stand it is found once
  std::vector<std::unique_ptr<PairsBeyond>> pairs_beyond_;  // between own points and other processes'
  std::vector<std::unique_ptr<FormulaPassages>> formula_passages_;
  AnglePassages angle_passages_;
};

}  // namespace tanor
