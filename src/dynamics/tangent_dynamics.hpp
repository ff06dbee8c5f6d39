#pragma once

#include <vector>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/instant.hpp"
#include "dynamics/tangent_linearization.hpp"
#include "dynamics/workspace.hpp"

namespace tanor {

/// Accelerations from forces in coordinates:
///
///   H q_ddot = A'(f - M psi),   H = A'MA        (28); w^(q) = G^-1 A'w is another number
///   w = A q_ddot + psi,  eta = M w - f          (24)
///
/// Accelerations in closed form leave A, the factor of H, r, v, psi and w0 out until somebody asks, for the power or
/// for what needs them, or charts change.
class TangentDynamics {
 public:
  /// Both outlive the dynamics.
  TangentDynamics(Workspace& work, TangentLinearization& linearization);
  /// Takes tau at every instant from equations with multipliers: friction that depends on reactions needs their
  /// multipliers (42).
  void take_friction_from(EquationsOfMotion* with_multipliers) { friction_ = with_multipliers; }
  /// Null: constraints are ideal.
  EquationsOfMotion* friction() const { return friction_; }

  bool has_work() const { return model_.is_rheonomic() || work_.forces.has_work() || friction_ != nullptr; }

  /// q_ddot [s] at (t, q, q_dot).
  Outcome solve(const Kinematics& at, const Request& request, const AccelerationOutput& to);
  /// r, v, psi, w0, A, the factor of H and q_ddot of the last solve, where they were left out.
  void complete();
  /// The same, w0 also into what that solve found.
  void complete(Reactions* found);

  /// Of the last solve: completed A as blocks and psi [3n].
  const std::vector<double>& blocks() { return completed().blocks(); }
  const std::vector<double>& psi() { return completed().psi(); }
  /// With the factor of the last solve.
  TangentLinearization& completed() {
    complete();
    return linearization_;
  }
  /// The coordinates [s] of the places r [3n]. Charts move: what was left out belongs to the old ones.
  void locate(const double* r, std::vector<double>* q) {
    complete();
    work_.coordinates.locate(r, q->data());
  }
  /// r(q + h q_dot + h^2/2 q_ddot, t + h) [3n] from the last solve.
  void write_place_along(double h, double* r);
  /// eta [3n] of what was found at (t, q, q_dot) (24); of supports: what the coordinates do there.
  void write_reactions(const Kinematics& at, const Reactions& found, double* eta);
  /// tau [3n] of what was found.
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
  SolveReport report_;                     // of the solve at hand
  EquationsOfMotion* friction_ = nullptr;  // null: constraints are ideal
  const bool has_closed_form_;
  double t_ = 0.0;
  std::vector<double> last_q_, last_q_dot_, last_q_ddot_;  // [s] of the last solve
  std::vector<double> w_, w0_;                             // [3n]; w0 = M^-1 f
  std::vector<double> friction_w_, tau_;                   // [3n] of the equations with multipliers, …
  Reactions friction_found_;                               // … and what was found with them
  std::vector<double> points_, columns_;                   // [3n], [s] scratch
};

}  // namespace tanor
