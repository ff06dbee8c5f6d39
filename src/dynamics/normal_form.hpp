#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "assembly/reactions.hpp"
#include "base/parallel.hpp"
#include "dynamics/mechanics.hpp"
#include "evaluate/constraints.hpp"
#include "evaluate/forces.hpp"
#include "solve/normal_solver.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The inverse problem in normal form, in the inner order of points and rows:
///
///   S lambda = -(phi + K'M^-1 f)        S = K'M^-1K      (31), with K'w_N = -phi
///   w = M^-1 (f + K lambda)                              (25)
///
/// Supports take part as points of infinite mass whose acceleration is prescribed: w0 = M^-1 f on moving points and the
/// support's own acceleration there, so that K'w0 carries both and phi needs no term of its own for them.
class NormalForm final : public Mechanics {
 public:
  /// `t`: where the system is checked and "initial" values are taken.
  NormalForm(System system, SolverOptions options, double t = 0.0);

  std::size_t size() const override { return 3 * numbering_.num_points(); }
  std::size_t point_size() const override { return 3; }
  bool depends_on_velocity() const override { return forces_.depends_on_velocity(); }
  bool has_work() const override { return is_rheonomic() || forces_.has_work(); }

  void prescribe(double t, double* r, double* v) override;
  Outcome linearise(double t, const double* r) override;
  Outcome accelerations(double t, const double* r, const double* v, Gradients gradients, double* w) override;
  Outcome free_accelerations(double t, const double* r, const double* v, double* w) override;
  ProjectionReport project_positions(double t, double* r) override;
  ProjectionReport project_step(double t, double h, double* r, double* step_velocity) override;
  ProjectionReport project_velocities(double t, const double* r, double* v) override;
  Power power(const double* r, const double* v) const override;
  Energy energy(const double* r, const double* v) const override;
  const SolveReport& last_solve() const override { return last_; }
  const Parallel& parallel() const override { return parallel_; }

  /// Supports that do not move as well: for arrays that come from outside.
  void prescribe_all(double t, double* r, double* v);

  /// Nearest consistent start in the M-norm; `StartMode::Check` throws InputError naming the worst constraint.
  StartReport start(double t, double* r, double* v, StartMode mode);
  /// Goes on with a motion from elsewhere: its earlier steps are unknown, the work is counted on.
  void resume(const Counters& counters, const PhaseTimes& times);
  /// Nearest point of xi = 0 to r in the M-norm, however far.
  ProjectionReport project_far(double t, double* r);
  /// w_N = -K Gamma^-1 phi (21), with what is prescribed at t in r and v.
  Outcome normal_accelerations(double t, const double* r, const double* v, double* w_normal);

  double position_violation(double t, const double* r);
  double velocity_violation(double t, const double* r, const double* v);

  /// Refine lambda and w to the rounding of |K'w + phi| (else: to 1e-12 of its scale).
  void set_exact(bool exact) { exact_ = exact; }

  const System& system() const { return system_; }
  const Numbering& numbering() const { return numbering_; }
  const std::vector<double>& multipliers() const { return lambda_; }
  const std::vector<double>& active_forces() const { return f_; }
  /// eta = K lambda [3n], of the last solve.
  void reactions(double* eta) const { gather_.reactions(parallel_, blocks_.data(), lambda_.data(), eta); }
  /// What each support carries, K lambda + f there [3n]; 0 on moving points.
  void support_forces(double* load) const;
  /// Largest |x_i|, and largest |x_i - y_i|, over the points.
  double largest_norm(const double* x) const;
  double largest_move(const double* x, const double* y) const;
  const PlanSummary& plan() const { return plan_; }
  const PhaseTimes& times() const { return times_; }
  const Counters& counters() const { return counters_; }
  double velocity_scale() const { return velocity_scale_; }

 private:
  struct PrescribedPoints {
    VectorFunction displacement;
    std::vector<Index> points;   // inner
    std::vector<Vec3> position;  // initial
  };

  bool is_rheonomic() const { return !moving_supports_.empty() || constraints_.depends_on_time(); }
  std::size_t num_moving() const { return numbering_.num_moving; }
  std::size_t num_rows() const { return constraints_.num_rows(); }
  void set_time(double t);
  void prescribe(const std::vector<PrescribedPoints>& supports, double t, double* r, double* v);
  double evaluate_free(double t, const double* r, const double* v, double* w0);  // returns max |w0|
  Outcome factorize(double t);
  void correct(double* rows, double* points);
  ProjectionReport iterate_onto_positions(double t, double* r, double* sum);
  ProjectionReport reach_constraints(double t, double* r);
  Outcome slope_towards(const std::vector<double>& wanted, double t, const double* r, double* d);
  std::string name_row(std::size_t inner_row) const;
  double rounding_floor(const double* r) const;
  Outcome not_finite(double t) const;
  Outcome explain_stall(double t, double violation) const;
  Outcome explain_singular(double t, std::size_t weakest_row) const;
  Outcome check_idle_rows(double t, double scale) const;
  void plan_what_is_left_out();

  System system_;
  Parallel parallel_;
  Numbering numbering_;
  Constraints constraints_;
  Forces forces_;
  std::vector<double> mass_, inverse_mass_;  // [point]; supports: 0 and 0
  std::vector<Incidence> incidences_;
  ReactionGather gather_;
  NormalSolver solver_;
  std::vector<PrescribedPoints> fixed_supports_, moving_supports_;
  std::vector<double> support_accelerations_;  // [3 * supports]

  // The last instant.
  double time_;
  bool is_factorized_ = false, exact_ = false;
  SolveReport last_;
  std::vector<double> blocks_;                      // K
  std::vector<double> f_, dw_;                      // [3n] f; w - w0 = M^-1 K lambda
  std::vector<double> right_side_, lambda_, rows_;  // [d] phi + K'w0; multipliers; scratch
  struct StepMultipliers {
    std::vector<double> sum;           // of this step's iterations
    std::vector<double> last, before;  // of the last two steps, over h^2
  } step_multipliers_;
  double scene_size_ = 1.0, smallest_length_ = 1.0, velocity_scale_ = 1.0;

  PlanSummary plan_;
  PhaseTimes times_;
  Counters counters_;
};

}  // namespace tanor
