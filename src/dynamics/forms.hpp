#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "dynamics/multiplier_form.hpp"
#include "dynamics/tangent_form.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// A system in the forms that it needs.
class Forms {
 public:
  /// Validates; `t`: where the system is checked and "initial" values are taken. Throws InputError where a form is
  /// wanted that the system cannot have.
  Forms(System system, const SolverOptions& options, double t = 0.0) : Forms(std::move(system), options, t, nullptr) {}
  /// `make`(work) brings the only form; empty: those of this library serve.
  using MakeForm = std::function<std::unique_ptr<EquationsOfMotion>(Workspace& work)>;
  Forms(System system, const SolverOptions& options, double t, const MakeForm& make);

  Workspace work;
  const Model& model{work.model()};
  std::unique_ptr<MultiplierForm> normal;    ///< null: coordinates alone are given
  std::unique_ptr<TangentForm> tangent;      ///< null: no coordinates are given
  std::unique_ptr<EquationsOfMotion> given;  ///< somebody else's, in place of both; null: there are none
  EquationsOfMotion* main = nullptr;         ///< the form that steps and answers
  PlanSummary plan;

  double start_time() const { return start_time_; }  ///< where "initial" values stand
  bool is_tangent() const { return tangent != nullptr && main == tangent.get(); }

  /// Consistent start of `main`. Where both coordinates and constraints are given they must describe the same motion:
  /// the coordinates say where the points are, and the constraints are checked there.
  StartReport start(double t, double* r, double* v, StartMode mode);
  /// The other form at the state of `main`'s last accelerations w [3n] with its eta [3n]: the largest difference of w
  /// over the largest acceleration there, and of eta over the largest force, whichever is larger.
  Outcome compare(const Kinematics& at, const Request& request, const double* w, const double* eta,
                  double* disagreement);

  /// `main`'s own variables, and where their points are.
  struct Place {
    Kinematics own, points;
  };
  /// lambda [d] (the smallest where several serve) and eta [3n], which may be null, of what `main` found with its
  /// accelerations there. The tangent form knows eta; lambda then costs a solve of the normal form.
  Outcome reactions(const Place& at, const Request& request, const Reactions& found, double* lambda, double* eta);
  /// w and eta [3n] by the form that does not step, at (t, r, v); both forms are there.
  Outcome solve_other(const Kinematics& at, const Request& request, double* w, double* eta);

  /// Rank of K at r, where the last `reactions` were asked for.
  RankReport rank(const double* r, bool thoroughly);

 private:
  void choose(Form wanted);
  void check_completeness(double t, const double* r);
  void make_plan();

  double start_time_;
  std::string reason_;                                 // why the other form does not step
  std::vector<double> scratch_, other_w_, other_eta_;  // [3n]
  std::vector<double> x_, x_dot_, x_ddot_;             // of the other form, …
  Reactions found_;                                    // … and what it found
};

}  // namespace tanor
