#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "assembly/reactions.hpp"
#include "base/parallel.hpp"
#include "dynamics/drives.hpp"
#include "dynamics/joints.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/scales.hpp"
#include "evaluate/constraints.hpp"
#include "evaluate/forces.hpp"
#include "evaluate/parametrisation.hpp"
#include "schur/gram_solver.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// What a form's factorization costs, into the plan.
void describe_factor(const GramSolver::Summary& summary, PlanSummary* plan);

/// A system made ready for numbers, in the inner order of points and rows: what both forms of the dynamics stand on.
///
/// Supports take part as points of infinite mass whose acceleration is prescribed: w0 = M^-1 f on moving points and the
/// support's own acceleration there, so that K'w0 carries both and phi needs no term of its own for them.
class Model {
 public:
  /// Validates. `t`: where the system is checked and "initial" values are taken.
  Model(System given, const SolverOptions& options, double t);
  Model(const Model&) = delete;
  Model& operator=(const Model&) = delete;

  System system;
  const Parallel parallel;
  const Numbering numbering;
  Constraints constraints;
  Forces forces;
  Parametrisation coordinates;                   ///< empty where none are given
  const std::vector<double> mass, inverse_mass;  ///< [point]; supports: 0 and 0
  const std::vector<Incidence> incidences;       ///< of K
  const ReactionGather gather;                   ///< K lambda
  Joints joints;                                 ///< which points forces join, and how well these are known
  std::vector<double> f;                         ///< [3n] active forces of the last `evaluate_free`
  std::vector<double> support_accelerations;     ///< [3 * supports]
  const double scene_size, smallest_length;      ///< m
  double velocity_scale = 1.0;                   ///< m/s, largest of the scene
  Scales scales;                                 ///< what decides locally
  /// Constraints close loops, or hold one island in two places: trees of rods on one support never lose rank.
  const bool may_lose_rank;
  /// What formulas as constraints and as coordinates do between the looks of a step.
  const std::vector<std::unique_ptr<FormulaPassages>> constraint_passages, coordinate_passages;
  const double mass_ratio;  ///< largest over smallest of moving points under constraints
  Drives drives;
  PhaseTimes times;
  Counters counters;
  std::size_t rank = 0;  ///< of K, as it was decided last; every row with moving points where nothing was suspected

  std::size_t num_points() const { return numbering.num_points(); }
  std::size_t num_moving() const { return numbering.num_moving; }
  /// With those of contacts that may stick; `numbering.num_user_rows` are the user's.
  std::size_t num_rows() const { return constraints.num_rows(); }
  bool has_friction() const { return constraints.tangents().size() > 0; }
  bool has_moving_supports() const { return !moving_supports_.empty(); }
  /// Reactions may do work.
  bool is_rheonomic() const {
    return has_moving_supports() || constraints.depends_on_time() || coordinates.depends_on_time();
  }
  /// Constraints and coordinates at t. Throws InputError where a table ends before t.
  void set_time(double t);
  double time() const { return time_; }

  /// What is prescribed at t, into r and v [3n]: at moving supports; at all of them, for arrays that come from outside.
  void prescribe(double t, double* r, double* v) { prescribe(moving_supports_, t, r, v); }
  void prescribe_all(double t, double* r, double* v);

  /// f at (t, r, v), and w0 [3n]: M^-1 f on moving points, the prescribed acceleration at supports. Returns max |w0|.
  double evaluate_free(double t, const double* r, const double* v, double* w0,
                       Forces::Which which = Forces::Which::All);

  /// The same for given forces [3n].
  double accelerate(const double* given, double* w0) const;

  /// w0 of every moving point, where gravity alone acts; else null.
  const Vec3* uniform_free() const { return uniform_free_ ? &*uniform_free_ : nullptr; }
  /// Where `uniform_free` says the others: the prescribed accelerations of supports, and those of points without
  /// constraints, into w0 [3n]. Returns its length.
  double write_unconstrained(double* w0) const;
  /// Those of all points.
  void write_uniform(double* w0) const;

  /// Assembles and factorizes S or H, timed and counted.
  GramSolver::Quality factorize(GramSolver* solver, const double* blocks);

  /// Velocity scales, of the scene and of each neighbourhood: what moves, what is prescribed, and a free fall through
  /// it.
  void measure_velocity_scale(double t, const double* r, const double* v);
  /// Takes over what was measured where the motion began.
  void exchange_memory(Memory& memory);

  Energy energy(const double* r, const double* v) const;
  /// Power of the reactions on the moving points, and of the forces without potential; at the last `evaluate_free`.
  Power power(const double* reaction_accelerations, const double* r, const double* v) const;
  /// How well each row of K is known at r for decisions on its rank: to the distance from xi = 0. [d]
  std::vector<double> rank_tolerances(const double* r);
  /// Largest relative violation of positions; of velocities, over the speed of their neighbourhood.
  double position_violation(double t, const double* r);
  double velocity_violation(double t, const double* r, const double* v);
  /// `atol` 0: each point's own, see Scales.
  ErrorRatios error_ratios(const StepErrors& errors, double atol, double rtol) const;

  /// Largest |x_i|, and largest |x_i - y_i|, over the points.
  double largest_norm(const double* x) const;
  double largest_move(const double* x, const double* y) const;
  /// The largest |x_i| of each neighbourhood, over its moving points.
  std::vector<double> largest_norms(const double* x) const;
  void largest_norms(const double* x, std::vector<double>* result) const;
  /// Largest |x_i - y_i| over the moving points, each over the `scale` of its neighbourhood.
  double largest_move(const double* x, const double* y, const std::vector<double>& scale) const;

  /// Some force, or some of `formulas`, may act between the looks of a step alone.
  using Formulas = std::vector<std::unique_ptr<FormulaPassages>>;
  bool may_be_passed(const Formulas& formulas) const { return forces.may_be_passed() || !formulas.empty(); }
  /// The part of a step to make instead of one that passes them unseen; 1: it passes none.
  double find_passage(const Formulas& formulas, PointPath* path);

  std::string name_row(std::size_t inner_row) const;
  /// Rows of contacts := 0 in K: what the system's constraints alone span, whatever sticks.
  void clear_contacts(double* blocks) const;
  /// The same in a copy.
  std::vector<double> without_contacts(const std::vector<double>& blocks) const;
  /// "friction0 at wire[4], point 3"
  std::string name_contact(std::size_t contact) const;
  /// Where T stands, each contact has directions to slide in.
  Outcome check_contacts(double t) const;
  Outcome not_finite(double t) const;

 private:
  struct PrescribedPoints {
    VectorFunction displacement;
    std::vector<Index> points;   // inner
    std::vector<Vec3> position;  // initial
  };
  void prescribe(const std::vector<PrescribedPoints>& supports, double t, double* r, double* v);
  void measure_local_speeds(const double* r, const double* v, const double* w0);

  std::vector<PrescribedPoints> fixed_supports_, moving_supports_;
  const std::optional<Vec3> uniform_free_;
  const std::size_t num_constrained_;  // moving points that constraints join; they come first
  double time_;
  std::vector<double> rows_;  // [d] scratch
};

}  // namespace tanor
