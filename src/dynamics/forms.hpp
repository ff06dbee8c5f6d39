#pragma once

#include <memory>

#include "dynamics/model.hpp"
#include "dynamics/normal_form.hpp"

namespace tanor {

/// A system in the forms that it needs.
struct Forms {
  /// Validates; `t`: where the system is checked and "initial" values are taken.
  Forms(System system, const SolverOptions& options, double t = 0.0);

  Model model;
  std::unique_ptr<NormalForm> normal;
  EquationsOfMotion* main = nullptr;  ///< the form that steps and answers
  PlanSummary plan;

  /// What each support carries [3n], eta + f there, after `main`'s accelerations; 0 on moving points.
  void support_forces(double* carried) const;

 private:
  void make_plan();
};

}  // namespace tanor
