#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "evaluate/angle_features.hpp"
#include "evaluate/energy_forces.hpp"
#include "evaluate/formula_features.hpp"
#include "evaluate/formula_forces.hpp"
#include "evaluate/given_forces.hpp"
#include "evaluate/pair_field.hpp"
#include "evaluate/pairs_beyond.hpp"
#include "evaluate/spring_forces.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The active forces f(r, v, t) of a system, in the inner order.
///
/// Each sort of force evaluates its own part. Here they are added up, point by point in a fixed order, so any number of
/// threads gives the same bits.
class Forces {
 public:
  Forces(const System& system, const Numbering& numbering);

  /// Returns true if some force has no potential: drag, damping, a formula, or a force that depends on time.
  bool has_work() const {
    return !drags_.empty() || springs_.has_damping() || given_.depend_on_time() || energies_.depends_on_time() ||
           !formulas_.empty();
  }
  bool depends_on_velocity() const {
    return !drags_.empty() || springs_.has_damping() || formulas_.depends_on_velocity();
  }
  /// True if forces are given as functions of time, which may end (tables). `set_time` throws InputError there.
  bool depend_on_time() const { return given_.depend_on_time(); }
  void set_time(double t) { given_.set_time(t); }
  bool has_pairs() const { return !pairs_.empty() || !pairs_beyond_.empty(); }
  /// Adds pair forces that reach to other processes. Calls that need them are collective from here on.
  void add_pairs_beyond(std::unique_ptr<PairsBeyond> pairs) { pairs_beyond_.push_back(std::move(pairs)); }
  bool has_springs() const { return !springs_.empty(); }
  bool has_energies() const { return !energies_.empty(); }
  bool has_formulas() const { return !formulas_.empty(); }
  const SpringForces& springs() const { return springs_; }
  const EnergyForces& energies() const { return energies_; }

  /// Returns M^-1 f of every moving point if gravity alone acts.
  std::optional<Vec3> uniform_acceleration() const {
    const bool others =
        has_springs() || has_pairs() || has_energies() || !given_.empty() || !drags_.empty() || has_formulas();
    return others ? std::nullopt : std::optional(gravity_);
  }

  /// Evaluates f [3n], N. Compliant springs may be left out, see SpringForces.
  enum class Which { All, WithoutCompliant };
  void evaluate(const Parallel& parallel, double t, const double* r, const double* v, double* f,
                Which which = Which::All);

  /// Returns the largest single force on a moving point at the last `evaluate`, N: gravity, or one spring, tuple,
  /// formula or given force alone. The pair forces of one entry count together.
  double largest_single(const Parallel& parallel, const double* r);

  /// Evaluates only what `power` and `EnergyForces::explicit_rate` read of `evaluate`.
  void evaluate_powers(const Parallel& parallel, double t, const double* r, const double* v);

  /// Returns true if some forces may act between the looks of a step alone: pairs, formulas and energies with narrow
  /// features, or angles at which laws end.
  bool may_be_passed() const { return act_briefly() || !angle_features_.empty(); }
  /// Returns the same but for the angles.
  bool act_briefly() const { return has_pairs() || !formula_features_.empty(); }
  /// Returns true if some of these forces may jump where points reach a certain place.
  bool may_jump() const;
  /// Returns the part of a step to make instead of one that passes such forces unseen, or 1 if it passes none. Notes
  /// in `path` where a force jumps first; pairs with points of other processes are left out.
  double find_unseen(const Parallel& parallel, PointPath* path);
  /// Returns the pair forces of moving points, as the system lists them.
  std::span<const PairField> pairs() const { return pairs_; }

  /// Returns all springs as pairs of points.
  std::vector<Coupling> list_couplings() const { return springs_.list_couplings(); }
  /// Returns the influences between the points of a tuple with an energy or a formula, one for each ordered pair of
  /// them.
  std::vector<Influence> list_influences() const;
  /// Evaluates df/dr and df/dv at (t, r, v) of springs, drag, formulas, energies and pair forces of few points with a
  /// smooth law; those of other pair forces are left out. Compliant springs are taken at given `tau`, or as all others
  /// if it is null.
  void evaluate_derivatives(const Parallel& parallel, double t, const double* r, const double* v, const double* tau,
                            const ForceDerivatives& to);

  /// Calls PairField::for_each_stiffness for the pair forces that `evaluate_derivatives` leaves out.
  void for_each_pair_stiffness(const Parallel& parallel, const double* r, const PairField::VisitStiffness& visit);

  /// Calls PairField::for_each_image for all pair forces.
  void for_each_image(const Parallel& parallel, const double* r, const PairField::VisitImage& visit) {
    for (PairField& pairs : pairs_) pairs.for_each_image(parallel, r, visit);
  }

  /// Returns the potential energy of gravity, constant forces, springs, pairs and tuples at t, J. The energy of springs
  /// and of pairs between a support and a moving point is included. Pair forces between two supports are loads on these
  /// (f), and have no energy here.
  double potential(const Parallel& parallel, double t, const double* r);
  /// Returns the part of it that belongs to one entry of pair forces, by its number among these.
  double potential_of_pairs(const Parallel& parallel, std::size_t entry, const double* r) {
    return pairs_[entry].potential(parallel, r);
  }
  /// Returns the power of the forces without potential on the moving points, W, at the (t, r, v) of the last
  /// `evaluate`.
  double power(const Parallel& parallel, const double* r, const double* v) const;
  /// Returns the power that moving supports put in through springs, pairs and tuples, W, at the (t, r, v) of the last
  /// `evaluate`.
  double elastic_power_of_supports(const Parallel& parallel, const double* r, const double* v);

  /// Leaves out what an entry of pair forces does between supports, where another process asks for it.
  void leave_out_pairs_of_supports(std::size_t entry) { pairs_of_supports_[entry].reset(); }

 private:
  class Reader;

  std::size_t num_points_ = 0, num_moving_ = 0;
  std::vector<double> mass_;                           // [moving point], kg
  std::vector<std::pair<std::size_t, double>> rigid_;  // points that prestress holds, and their masses, kg
  Vec3 gravity_{};
  GivenForces given_;
  Groups<DragNumbers> drags_;
  SpringForces springs_;
  FormulaForces formulas_;
  EnergyForces energies_;
  std::vector<PairField> pairs_;  // each keeps what belongs to the positions it saw last
  /// [entry] between supports, found once if these stand; null if there are none
  std::vector<std::unique_ptr<PairField>> pairs_of_supports_;
  std::vector<std::unique_ptr<PairsBeyond>> pairs_beyond_;  // between own points and other processes'
  std::vector<std::unique_ptr<FormulaFeatures>> formula_features_;
  AngleFeatures angle_features_;
};

}  // namespace tanor::detail
