#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/drives.hpp"
#include "dynamics/joints.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/model.hpp"
#include "dynamics/scales.hpp"
#include "dynamics/team.hpp"
#include "schur/factor_summary.hpp"
#include "schur/gram_solver.hpp"

namespace tanor::detail {

/// Writes the cost of a form's factorization into the plan.
void describe_factor(const FactorSummary& factor, PlanSummary* plan);

/// A model and all data that changes with it: its families, which are at one time; the last forces, prescribed motion
/// and scales; the rank of K, the work done and the time it took.
class Workspace : public Families {
  Model model_;  // before the members that are made of it

 public:
  /// Makes the team of a workspace that has a part of a system; empty if the process is alone.
  using MakeTeam = std::function<std::unique_ptr<Team>(Workspace&)>;
  /// Validates the system, with checks and "initial" values at the time `t`.
  Workspace(System given, const SolverOptions& options, double t, const MakeTeam& make_team = {});
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;

  const Model& model() const { return model_; }
  Team& team() const { return *team_; }
  /// Returns true if some process of the team has rows, or reactions that may do work.
  bool has_rows() const { return has_rows_; }
  bool is_rheonomic() const { return is_rheonomic_; }

  Joints joints;  ///< groups of points that forces join, and their rounding
  Drives drives;
  Scales scales;                ///< the scales of each neighbourhood
  double velocity_scale = 1.0;  ///< m/s, largest of the scene
  std::vector<double> f;        ///< [3n] active forces of the last `evaluate_free`
  /// Formulas of constraints and of coordinates that a step may pass unseen.
  using Formulas = std::vector<std::unique_ptr<FormulaFeatures>>;
  Formulas constraint_features, coordinate_features;
  PhaseTimes times;
  Counters counters;
  std::size_t rank;  ///< of K by the last decision; all rows with moving points if nothing was suspected

  /// Moves constraints and coordinates to t. Throws InputError if a table ends before t.
  void set_time(double t);
  double time() const { return time_; }

  /// Write the prescribed motion at t into r and v [3n], of moving supports, or of all supports for arrays that come
  /// from outside.
  void prescribe(double t, double* r, double* v);
  void prescribe_all(double t, double* r, double* v);

  /// Computes f at (t, r, v), and w0 [3n]: M^-1 f on moving points, the prescribed acceleration at supports. Returns
  /// max |w0| of this process.
  double evaluate_free(double t, const double* r, const double* v, double* w0,
                       Forces::Which which = Forces::Which::All);
  /// Writes the prescribed accelerations of supports at t into w0 [3n].
  void write_support_accelerations(double t, double* w0);
  /// Writes the prescribed accelerations of supports, and those of points without constraints, into w0 [3n]. Returns
  /// the length of `Model::uniform_free`, which holds for the other points, or 0 if it is null.
  double write_unconstrained(double t, double* w0);
  /// Writes the accelerations of all points likewise.
  void write_uniform(double t, double* w0);

  /// Assembles and factorizes S or H, with time and count.
  GramSolver::Quality factorize(GramSolver* solver, const double* blocks);

  /// Measures the velocity scales, of the scene and of each neighbourhood: velocities, prescribed motion, and a free
  /// fall over its length.
  void measure_velocity_scale(double t, const double* r, const double* v);
  /// Exchanges the scales measured where the motion began.
  void exchange_memory(Memory& memory);

  Energy energy(double t, const double* r, const double* v);
  double potential(double t, const double* r);
  /// Returns the power of forces without potential, and of moving supports through forces and, as given, through
  /// constraints, at the last `evaluate_free`.
  Power power(double of_constraints, const Kinematics& at);
  /// Returns the power of the reactions on moving points, from M^-1 eta [3n], or 0 where they do no work.
  double power_of_reactions(const double* accelerations, const double* v) const;
  /// Returns the reason why the state at t and r, or a force there, is not finite. Names the tuple whose energy is
  /// undefined.
  Outcome not_finite(double t, const double* r) const;
  /// Returns the accuracy of each row of K at r for decisions on its rank [d], which follows from the distance to
  /// xi = 0.
  std::vector<double> rank_tolerances(const double* r);
  /// Return the largest relative violation of positions, and of velocities over the speed of their neighbourhood.
  double position_violation(double t, const double* r);
  double velocity_violation(double t, const double* r, const double* v);
  /// With `atol` = 0 each point has its own tolerance, see Scales.
  ErrorRatios error_ratios(const StepErrors& errors, double atol, double rtol) const;

  /// Compute the largest |x_i| of each neighbourhood, over its moving points.
  std::vector<double> largest_norms(const double* x) const;
  void largest_norms(const double* x, std::vector<double>* result) const;
  /// Returns the largest |x_i - y_i| over the moving points, each over the `scale` of its neighbourhood.
  double largest_move(const double* x, const double* y, const std::vector<double>& scale) const;

  /// Returns "pair0: points 3 and 7 …" for two points that collide within so many seconds, or an empty string.
  std::string find_collision(const Kinematics& points, double within) const;

  std::string name_row(std::size_t inner_row) const;
  /// Sets the rows of contacts in K to 0, so that only the system's constraints are left.
  void clear_contacts(double* blocks) const;
  /// Does the same in a copy.
  std::vector<double> without_contacts(const std::vector<double>& blocks) const;
  /// Returns e.g. "friction0 at wire[4], point 3".
  std::string name_contact(std::size_t contact) const;
  /// Checks that each contact has directions to slide in, where T is known.
  Outcome check_contacts(double t) const;

 private:
  Workspace(NumberedSystem numbered, double t);
  void measure_local_speeds(const double* r, const double* v, const double* w0);

  std::unique_ptr<Team> team_ = std::make_unique<Team>();
  bool has_rows_ = false, is_rheonomic_ = false;
  double time_;
  double supports_at_;                         // s, the instant of …
  std::vector<double> support_accelerations_;  // … these, [3 * supports]
  std::vector<double> rows_;                   // [d] scratch
  std::vector<double> own_v_;                  // [3n] scratch
};

}  // namespace tanor::detail
