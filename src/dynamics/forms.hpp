#pragma once

#include <memory>

#include "dynamics/model.hpp"
#include "dynamics/normal_form.hpp"
#include "dynamics/tangent_form.hpp"

namespace tanor {

/// A system in the forms that it needs.
class Forms {
 public:
  /// Validates; `t`: where the system is checked and "initial" values are taken. Throws InputError where a form is
  /// wanted that the system cannot have.
  Forms(System system, const SolverOptions& options, double t = 0.0);

  Model model;
  std::unique_ptr<NormalForm> normal;    ///< null: coordinates alone are given
  std::unique_ptr<TangentForm> tangent;  ///< null: no coordinates are given
  EquationsOfMotion* main = nullptr;     ///< the form that steps and answers
  PlanSummary plan;

  double start_time() const { return start_time_; }  ///< where "initial" values stand
  bool is_tangent() const { return main == tangent.get(); }

  /// lambda [d] (the smallest where several serve) and eta [3n] that belong to `main`'s last accelerations, at
  /// (t, r, v). The tangent form knows eta; lambda then costs a solve of the normal form.
  Outcome reactions(double t, const double* r, const double* v, double* lambda, double* eta);
  /// w and eta [3n] by the form that does not step, at (t, r, v); both forms are there.
  Outcome solve_other(double t, const double* r, const double* v, double* w, double* eta);

  /// Rank of K at r, where the last `reactions` were asked for.
  RankReport rank(const double* r, bool thoroughly);

 private:
  void choose(Form wanted);
  void make_plan();

  double start_time_;
  std::vector<double> scratch_;             // [3n]
  std::vector<double> x_, x_dot_, x_ddot_;  // of the other form
};

}  // namespace tanor
