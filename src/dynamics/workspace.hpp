#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/drives.hpp"
#include "dynamics/joints.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/model.hpp"
#include "dynamics/scales.hpp"
#include "schur/gram_solver.hpp"

namespace tanor {

/// What a form's factorization costs, into the plan.
void describe_factor(const GramSolver::Summary& summary, PlanSummary* plan);

/// A model and all that moves while it is computed: its families, which stand at one time; forces, prescribed motion
/// and scales that were found last; the rank of K, the work done and the time it took.
class Workspace : public Families {
  Model model_;  // before what is made of it

 public:
  /// Validates. `t`: where the system is checked and "initial" values are taken.
  Workspace(System given, const SolverOptions& options, double t);
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  const Model& model() const { return model_; }

  Joints joints;  ///< which points forces join, and how well these are known
  Drives drives;
  Scales scales;                              ///< what decides locally
  double velocity_scale = 1.0;                ///< m/s, largest of the scene
  std::vector<double> f;                      ///< [3n] active forces of the last `evaluate_free`
  std::vector<double> support_accelerations;  ///< [3 * supports] of the last `prescribe`
  /// What formulas as constraints and as coordinates do between the looks of a step.
  using Formulas = std::vector<std::unique_ptr<FormulaPassages>>;
  Formulas constraint_passages, coordinate_passages;
  PhaseTimes times;
  Counters counters;
  std::size_t rank;  ///< of K, as it was decided last; every row with moving points where nothing was suspected

  /// Constraints and coordinates at t. Throws InputError where a table ends before t.
  void set_time(double t);
  double time() const { return time_; }

  /// What is prescribed at t, into r and v [3n]: at moving supports; at all of them, for arrays that come from outside.
  void prescribe(double t, double* r, double* v) { model_.prescribe(t, {r, v, support_accelerations.data()}); }
  void prescribe_all(double t, double* r, double* v) { model_.prescribe_all(t, {r, v, support_accelerations.data()}); }

  /// f at (t, r, v), and w0 [3n]: M^-1 f on moving points, the prescribed acceleration at supports. Returns max |w0|.
  double evaluate_free(double t, const double* r, const double* v, double* w0,
                       Forces::Which which = Forces::Which::All);
  /// The same for given forces [3n].
  double accelerate(const double* given, double* w0) const;
  /// What is prescribed at supports, into w0 [3n].
  void write_support_accelerations(double* w0) const;
  /// Where `Model::uniform_free` says the others: the prescribed accelerations of supports, and those of points without
  /// constraints, into w0 [3n]. Returns its length.
  double write_unconstrained(double* w0) const;
  /// Writes the accelerations of all points likewise.
  void write_uniform(double* w0) const;

  /// Assembles and factorizes S or H, timed and counted.
  GramSolver::Quality factorize(GramSolver* solver, const double* blocks);

  /// Velocity scales, of the scene and of each neighbourhood: what moves, what is prescribed, and a free fall through
  /// it.
  void measure_velocity_scale(double t, const double* r, const double* v);
  /// Takes over what was measured where the motion began.
  void exchange_memory(Memory& memory);

  Energy energy(double t, const double* r, const double* v);
  /// Power of the forces without potential, and of moving supports through forces and, as given, through constraints;
  /// at the last `evaluate_free`.
  Power power(double of_constraints, const double* r, const double* v);
  /// Power of the reactions on the moving points, from M^-1 eta [3n]; not asked for where they do no work.
  double power_of_reactions(const double* accelerations, const double* v) const;
  /// Why the state at t and r, or what acts there, is not finite: names the tuple whose energy ends there.
  Outcome not_finite(double t, const double* r) const;
  /// How well each row of K is known at r for decisions on its rank: to the distance from xi = 0. [d]
  std::vector<double> rank_tolerances(const double* r);
  /// Largest relative violation of positions; of velocities, over the speed of their neighbourhood.
  double position_violation(double t, const double* r);
  double velocity_violation(double t, const double* r, const double* v);
  /// `atol` 0: each point's own, see Scales.
  ErrorRatios error_ratios(const StepErrors& errors, double atol, double rtol) const;

  /// The largest |x_i| of each neighbourhood, over its moving points.
  std::vector<double> largest_norms(const double* x) const;
  void largest_norms(const double* x, std::vector<double>* result) const;
  /// Largest |x_i - y_i| over the moving points, each over the `scale` of its neighbourhood.
  double largest_move(const double* x, const double* y, const std::vector<double>& scale) const;

  /// Some force, or some of `formulas`, may act between the looks of a step alone.
  bool may_be_passed(const Formulas& formulas) const { return forces.may_be_passed() || !formulas.empty(); }
  /// The part of a step to make instead of one that passes them unseen; 1: it passes none.
  double find_passage(const Formulas& formulas, PointPath* path);
  /// "pair0: points 3 and 7 …": two that fall onto each other within so many seconds; empty: none do.
  std::string find_collision(const Kinematics& points, double within) const;

  std::string name_row(std::size_t inner_row) const;
  /// Rows of contacts := 0 in K: what the system's constraints alone span, whatever sticks.
  void clear_contacts(double* blocks) const;
  /// The same in a copy.
  std::vector<double> without_contacts(const std::vector<double>& blocks) const;
  /// "friction0 at wire[4], point 3"
  std::string name_contact(std::size_t contact) const;
  /// Where T stands, each contact has directions to slide in.
  Outcome check_contacts(double t) const;

 private:
  Workspace(NumberedSystem numbered, double t);
  void measure_local_speeds(const double* r, const double* v, const double* w0);

  double time_;
  std::vector<double> rows_;  // [d] scratch
};

}  // namespace tanor
