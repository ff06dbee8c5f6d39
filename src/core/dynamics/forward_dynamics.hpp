#pragma once

#include <span>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Computes the accelerations from the forces, and the Lagrange multipliers of the constraints:
///
///   S lambda = -(phi + K'M^-1 f)        S = K'M^-1K      (31)
///   eta = K lambda                                        (23)
///   w = M^-1 (f + eta)                                    (25)
///
/// w0 = M^-1 f, with the prescribed accelerations of supports (see Model), stands in place of M^-1 f. With friction,
/// f + tau stands in place of f.
class ForwardDynamics {
 public:
  /// `contacts` is null if constraints are ideal. All arguments must outlive this object.
  ForwardDynamics(Workspace& work, Linearization& linearization, Residuals& residuals, Contacts* contacts);

  /// Computes w [3n] at (t, r, v), with K and the factor of S at this configuration or with the present ones.
  Outcome solve(const Kinematics& at, const Request& request, const AccelerationOutput& to) {
    return solve(at, request, {}, to);
  }
  /// `are_counted` [island of contacts] marks islands whose motions are known, see UniquenessCheck. It is empty if
  /// there are none.
  Outcome solve(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                const AccelerationOutput& to);

  /// The multipliers lambda [d], which are a part of the state where friction reads them: the fixed point (43) is
  /// searched from them on, and each solve leaves its own here.
  std::vector<double>& multipliers() { return found_.lambda; }
  /// Writes eta = K lambda [3n] (23) of the user's constraints, where K stands. At supports it is the force of the
  /// constraints.
  void write_reactions(const std::vector<double>& lambda, double* eta);

 private:
  static constexpr double doubtful_above = 1e-9;  // |K'w + phi| over its terms that is more than rounding

  Outcome find(const Kinematics& at, const Request& request, std::span<const char> are_counted);
  Power find_power(const Kinematics& at);
  Outcome check_idle_rows(double t) const;
  Outcome find_friction(const Kinematics& at, const UniquenessCheck& check);
  void find_multipliers();
  void refine();
  void improve_friction();
  Outcome verify(const Kinematics& at, bool verifies_friction);
  Outcome reconsider_rank(double t, const double* r);
  Residuals::Problem problem() const { return {w_, found_.b.data(), found_.scale}; }

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Residuals& residuals_;
  Contacts* contacts_;        // null if constraints are ideal
  const bool has_idle_rows_;  // on some process
  bool exact_ = false;        // of the present solve
  SolveReport report_;        // of the present solve
  MultiplierSolution found_;  // by the present solve
  double* w_ = nullptr;       // [3n] of the present solve: w0, then w
  std::vector<double> rows_;  // [d] K'w + phi
};

}  // namespace tanor::detail
