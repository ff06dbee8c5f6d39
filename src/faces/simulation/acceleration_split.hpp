#pragma once

#include <memory>
#include <vector>

#include "dynamics/forms.hpp"
#include "dynamics/split.hpp"

namespace tanor::detail {

/// One instant as the forms solved it, in the inner order.
struct SolvedInstant {
  double t = 0.0;
  std::vector<double> r, v, w, eta, lambda;  ///< eta only if it was asked for
  Reactions found;
  Outcome outcome;
  SolveReport report;  ///< report on the instant, except for the outcome
};

/// Finds w_N, f_N and tau_N of an instant, the parts of accelerations, forces and friction in the normal space.
class AccelerationSplit {
 public:
  /// The forms must outlive the object.
  explicit AccelerationSplit(Forms& forms) : forms_(forms), work_(forms.work), model_(work_.model()) {}

  /// Writes w_N and f_N [3n] of an instant for which the forms are current.
  Outcome find(const SolvedInstant& at, double* w_N, double* f_N);
  /// Results of the last instant: tau and tau_N [3n], and how far (44) is from holding.
  const std::vector<double>& friction() const { return tau_; }
  const std::vector<double>& normal_friction() const { return tau_N_; }
  double mass_coupling() const { return mass_coupling_; }

 private:
  Outcome find_by_constraints(const SolvedInstant& at, double* w_N, double* f_N);
  Outcome find_by_coordinates(const SolvedInstant& at, double* w_N, double* f_N);

  Forms& forms_;
  Workspace& work_;
  const Model& model_;
  std::unique_ptr<NormalSpace> normal_space_;
  std::unique_ptr<TangentSpace> tangent_space_;
  std::vector<double> blocks_;  // blocks of K without contacts that stick
  std::vector<double> tau_, tau_N_;
  double mass_coupling_ = 0.0;
};

}  // namespace tanor::detail
