#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/multiplier_form.hpp"
#include "dynamics/tangent_form.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// A system with the forms that it needs.
class Forms {
 public:
  /// Validates the system, with checks and "initial" values at the time `t`. Throws InputError if the system cannot
  /// have the requested form. `ranks` have parts of one system, which choose the same form; null if the whole system is
  /// here. `make_team` is empty if nothing reaches from one to another. Collective.
  Forms(System system, const SolverOptions& options, double t = 0.0, const Workspace::MakeTeam& make_team = {},
        Ranks* ranks = nullptr);

  Workspace work;
  const Model& model{work.model()};
  std::unique_ptr<MultiplierForm> normal;  ///< null if coordinates alone are given
  std::unique_ptr<TangentForm> tangent;    ///< null if no coordinates are given
  EquationsOfMotion* main = nullptr;       ///< the form that steps and answers
  PlanSummary plan;

  double start_time() const { return start_time_; }  ///< the time of "initial" values
  bool is_tangent() const { return tangent != nullptr && main == tangent.get(); }

  /// Finds a consistent start of `main`. If both coordinates and constraints are given, they must describe the same
  /// motion. The coordinates say where the points are, and the constraints are checked there.
  StartReport start(double t, double* r, double* v, StartMode mode);
  /// Compares with the other form at the state of `main`'s last accelerations w [3n] with their eta [3n]. Writes the
  /// larger one of the largest difference of w over the largest acceleration there, and of eta over the largest force.
  Outcome compare(const Kinematics& at, const Request& request, const double* w, const double* eta,
                  double* disagreement);

  /// `main`'s own variables, and the kinematics of the points.
  struct Configuration {
    Kinematics own, points;
  };
  /// Writes lambda [d] (of least norm if not unique) and eta [3n], which may be null, of the reactions that `main`
  /// found with its accelerations there. The tangent form knows eta; lambda then costs a solve of the normal form.
  Outcome reactions(const Configuration& at, const Request& request, const Reactions& found, double* lambda,
                    double* eta);
  /// Computes w and eta [3n] at (t, r, v) by the form that does not step. Both forms must be there.
  Outcome solve_other(const Kinematics& at, const Request& request, double* w, double* eta);

  /// Returns 3(n - supports) - rank K of the rows that act, or the number of coordinates where these are alone. A rank
  /// that counts rows of others' points may have less than 0.
  double degrees_of_freedom() const;
  /// Returns the rank of K at r, the configuration of the last `reactions`. The rank and the degrees of freedom are
  /// those of all processes, the rest is this one's, which is unknown where equations reach from one to another.
  RankReport rank(const double* r, bool thoroughly);

 private:
  StartReport start_here(double t, double* r, double* v, StartMode mode);
  void choose(Form wanted, Decisions& all);
  void check_completeness(double t, const double* r);
  void make_plan();

  double start_time_;
  std::string reason_;                                 // why the other form does not step
  std::vector<double> scratch_, other_w_, other_eta_;  // [3n]
  std::vector<double> x_, x_dot_, x_ddot_;             // variables of the other form
  Reactions found_;                                    // its reactions
};

}  // namespace tanor::detail
