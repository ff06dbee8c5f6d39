#pragma once

#include <vector>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/tangent_linearization.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Computes accelerations from forces in coordinates:
///
///   H q_ddot = A'(f - M psi),   H = A'MA        (28); w^(q) = G^-1 A'w is another number
///   w = A q_ddot + psi,  eta = M w - f          (24)
///
/// Accelerations in closed form leave out A, the factor of H, r, v, psi and w0. These are computed when the power or
/// something else needs them, or when charts change.
class TangentDynamics {
 public:
  /// Both arguments must outlive this object.
  TangentDynamics(Workspace& work, TangentLinearization& linearization);
  /// Takes tau at every instant from equations with multipliers, since friction that depends on reactions needs their
  /// multipliers (42).
  void take_friction_from(EquationsOfMotion* with_multipliers) { friction_ = with_multipliers; }
  /// Null if constraints are ideal.
  EquationsOfMotion* friction() const { return friction_; }

  bool has_work() const { return model_.is_rheonomic() || work_.forces.has_work() || friction_ != nullptr; }

  /// Computes q_ddot [s] at (t, q, q_dot).
  Outcome solve(const Kinematics& at, const Request& request, const AccelerationOutput& to);
  /// Computes r, v, psi, w0, A, the factor of H and q_ddot of the last solve, if they were left out.
  void complete();
  /// Does the same, and writes w0 into the reactions of that solve.
  void complete(Reactions* found);

  /// A as blocks and psi [3n] of the last solve, completed.
  const std::vector<double>& blocks() { return completed().blocks(); }
  const std::vector<double>& psi() { return completed().psi(); }
  /// The linearization with the factor of the last solve, completed.
  TangentLinearization& completed() {
    complete();
    return linearization_;
  }
  /// Computes the coordinates [s] of the positions r [3n]. This moves charts, so parts that were left out are completed
  /// in the old ones.
  void locate(const double* r, std::vector<double>* q) {
    complete();
    work_.coordinates.locate(r, q->data());
  }
  /// Writes r(q + h q_dot + h^2/2 q_ddot, t + h) [3n] from the last solve.
  void write_place_along(double h, double* r);
  /// Writes eta [3n] of the reactions found at (t, q, q_dot) (24). At supports it is the force of the coordinates.
  void write_reactions(const Kinematics& at, const Reactions& found, double* eta);
  /// Writes tau [3n] of the reactions found.
  void write_friction(const Reactions& found, double* tau) const;

  void exchange_memory(Memory& memory);

 private:
  std::size_t size() const { return last_q_.size(); }
  Outcome find(const Kinematics& at, const Request& request, double* q_ddot);
  Power find_power();
  bool solve_in_closed_form(const Kinematics& at, double* q_ddot);
  Outcome find_friction(double t, const Request& request);
  void add_friction(const Reactions& found, double* w0);
  void refine(double scale, bool exact, double* q_ddot);
  double correct(double* q_ddot);
  double relative_correction(double correction, double scale) const;
  void remember(const Kinematics& at);

  Workspace& work_;
  const Model& model_;
  TangentLinearization& linearization_;
  SolveReport report_;                     // of the present solve
  EquationsOfMotion* friction_ = nullptr;  // null if constraints are ideal
  const bool has_closed_form_;
  double t_ = 0.0;
  std::vector<double> last_q_, last_q_dot_, last_q_ddot_;  // [s] of the last solve
  std::vector<double> w_, w0_;                             // [3n]; w0 = M^-1 f
  std::vector<double> friction_w_, tau_;                   // [3n] of the equations with multipliers
  Reactions friction_found_;                               // their reactions
  std::vector<double> points_, columns_;                   // [3n], [s] scratch
};

}  // namespace tanor::detail
