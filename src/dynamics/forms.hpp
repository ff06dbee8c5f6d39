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

  bool is_tangent() const { return main == tangent.get(); }

  /// lambda [d] (the smallest where several serve) and eta [3n] that belong to `main`'s last accelerations, at
  /// (t, r, v). The tangent form knows eta; lambda then costs a solve of the normal form.
  Outcome reactions(double t, const double* r, const double* v, double* lambda, double* eta);

  /// Rank of K at r, where the last `reactions` were asked for.
  RankReport rank(const double* r, bool thoroughly);

 private:
  void choose(Form wanted);
  void make_plan();

  std::vector<double> scratch_;  // [3n]
};

}  // namespace tanor
