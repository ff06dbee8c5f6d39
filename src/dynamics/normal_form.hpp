#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dynamics/contact_modes.hpp"
#include "dynamics/equations_of_motion.hpp"
#include "dynamics/friction_solver.hpp"
#include "dynamics/model.hpp"
#include "dynamics/motion_series.hpp"
#include "schur/gram_solver.hpp"
#include "schur/path_series.hpp"
#include "schur/redundancy.hpp"
#include "schur/reuse.hpp"
#include "schur/schur_solver.hpp"

namespace tanor {

/// The inverse problem in normal form:
///
///   S lambda = -(phi + K'M^-1 f)        S = K'M^-1K      (31), with K'w_N = -phi
///   w = M^-1 (f + K lambda)                              (25)
///
/// with w0 = M^-1 f, and what is prescribed at supports (see Model), in place of M^-1 f. Its variables are r
/// themselves. With friction, f + tau stands in place of f.
class NormalForm final : public EquationsOfMotion,
                         private StepProjector,
                         private InexactSolves,
                         private RankMonitor,
                         private RoundingGroups,
                         private ForcePassages,
                         private SeriesExpansion,
                         private DriveMonitor,
                         private ConstrainedSystem,
                         private ImplicitFormulation {
 public:
  NormalForm(Model& model, const SolverOptions& options);

  std::size_t size() const override { return 3 * model_.num_points(); }
  bool depends_on_velocity() const override { return model_.forces.depends_on_velocity() || friction_ != nullptr; }
  bool has_work() const override { return model_.is_rheonomic() || model_.forces.has_work() || friction_ != nullptr; }

  void prescribe(double t, double* r, double* v) override { model_.prescribe(t, r, v); }
  Outcome linearise(double t, const double* r) override;
  Outcome accelerations(const Kinematics& at, const Request& request, double* w) override;
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* w) override;
  ProjectionReport project_positions(double t, double* r, Turn turn = Turn::Small) override;
  ProjectionReport project_step(double t, double h, double* r, double* step_velocity) override;
  ProjectionReport project_velocities(double t, const double* r, double* v) override;
  ProjectionReport project_step_velocities(double t, double h, const double* r, double* v) override;
  double allowed_error(const StepTarget& target) const override;
  void exchange_memory(Memory& memory) override;
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  std::span<const Index> neighbourhoods() const override { return model_.scales.of_points(); }
  std::size_t num_groups() const override { return model_.joints.num_groups(); }
  void largest_differences(const double* a, const double* b, std::span<double> largest) const override {
    model_.joints.largest_differences(a, b, largest);
  }
  double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target) override {
    return model_.joints.allow_rounding(levels, gain, target, model_.scales);
  }
  bool matrix_knows_all_forces() const override { return !model_.forces.has_pairs(); }
  std::unique_ptr<ImplicitEquations> make_implicit_equations() override;
  Power power(const double* r, const double* v) const override;
  Energy energy(double, const double* r, const double* v) override { return model_.energy(r, v); }
  std::size_t num_accelerations() const override { return model_.counters.evaluations; }
  std::size_t rank() const override { return model_.rank; }
  double mass_ratio() const override { return model_.mass_ratio; }
  void remember_gradients() override;
  double compare_gradients() override;
  const SolveReport& last_solve() const override { return last_; }
  const Parallel& parallel() const override { return model_.parallel; }
  bool keeps_variables() const override { return true; }

  StepProjector* step_projector() override { return this; }
  InexactSolves* inexact_solves() override { return reuse_ != nullptr ? this : nullptr; }
  RankMonitor* rank_monitor() override { return model_.may_lose_rank ? this : nullptr; }
  /// Friction remembers what it was asked last: there nobody asks for more.
  RoundingGroups* rounding_groups() override { return friction_ == nullptr ? this : nullptr; }
  ForcePassages* force_passages() override { return model_.may_be_passed(model_.constraint_passages) ? this : nullptr; }
  SeriesExpansion* series() override;
  std::string why_no_series() const override;
  DriveMonitor* drives() override { return !model_.drives.empty() ? this : nullptr; }
  EventFunctions* events() override { return has_switches() ? contacts_.get() : nullptr; }
  ImplicitFormulation* implicit_formulation() override { return friction_ == nullptr ? this : nullptr; }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport put_positions(double t, double* r) override;
  ProjectionReport put_velocities(double t, const double* r, double* v) override;
  Outcome adopt(double t, const double* r, const double* v, double* x, double* x_dot) override;
  void write_points(double t, const double* x, const double* x_dot, const double* x_ddot, double* r, double* v,
                    double* w) override;
  void recentre(double t, double* r, double* v, double*) override {
    if (contacts_ != nullptr) contacts_->accept(t, r, v);
  }
  void resume(const Counters& counters, const PhaseTimes& times) override;
  /// lambda [d] of the last accelerations.
  const std::vector<double>& multipliers() const { return lambda_; }
  void reactions(double* eta) const override;
  /// tau [3n] of the last accelerations, of all contacts.
  void friction_forces(double* tau) const;
  /// Null: constraints are ideal.
  const FrictionSolver* friction() const { return friction_.get(); }

  std::size_t num_points() const override { return model_.num_points(); }
  Kinematics find_points(const Kinematics& at, double*, double*) override { return at; }
  PointTolerances point_tolerances() const override {
    return {model_.scales.position_tolerances(), model_.scales.velocity_tolerances(), model_.scales.accelerations()};
  }
  double find_passage(PointPath* path) override { return model_.find_passage(model_.constraint_passages, path); }

  Outcome expand(const Kinematics& at, const double* w, std::span<double* const> coefficients,
                 double* smooth_until) override;
  Power power_along(const Kinematics& at, const double* w) override;

  DriveReport look_at_drives(const DrivenStep& step) override {
    return model_.drives.look(step, {step.x, step.v, nullptr, model_.scales});
  }
  std::string name_drive(std::size_t drive) const override { return model_.drives.name(drive); }

  Outcome begin(double t, const double* r, double* v, const Request& request, double* w) override;
  void describe(PlanSummary* plan) const override;

  /// Nearest point of xi = 0 to r in the M-norm, however far.
  ProjectionReport project_far(double t, double* r);
  /// lambda = -S^-1 b [d] and dw = M^-1 K lambda [3n] for one more right-hand side, refined to rounding; with the
  /// factor of the last linearisation.
  void respond(const double* b, double* lambda, double* dw);
  /// lambda := the multipliers of the same reactions with the smallest norm, at the last accelerations (at r).
  void minimize_multipliers(const double* r, double* lambda);
  /// Rank of K at the last linearisation, at r: as it was decided where S raised a suspicion, else d. `thoroughly`:
  /// decides now.
  RankReport find_rank(const double* r, bool thoroughly);

  /// A contact whose reaction dependent constraints share by convention, at the last linearisation; empty: there is
  /// none.
  std::string find_undetermined_reaction() const {
    return contacts_ != nullptr ? contacts_->find_undetermined_reaction() : std::string();
  }

  /// Predicted flops of one evaluation and solve.
  double predicted_flops() const;
  /// Of S: "natural" where elimination makes no fill, "amd", …
  std::string ordering() const { return schur_ != nullptr ? schur_->summary().ordering : solver_->summary().ordering; }
  double estimate_reciprocal_condition();
  /// rows := -S^-1 rows with the last factor [d].
  void solve_negative(double* rows);
  /// K as blocks at the last linearisation.
  const std::vector<double>& blocks() const override { return blocks_; }

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught
  GramSolver& general();
  void describe_solver(PlanSummary* plan) const;
  bool has_schur() const { return schur_ != nullptr && !redundancy_.is_found(); }
  std::optional<Outcome> solve_schur(double t, const double* r, const double* v, Gradients gradients, double* w);
  bool factorize_schur();
  double evaluate_values(const double* r);
  double evaluate_rates(const double* r, const double* v);
  bool linearise_schur(const double* r);
  void project_islands(double target, double* r, double* sum, ProjectionReport* report);
  void project_island_velocities(double target, const double* r, double* v, ProjectionReport* report);
  Outcome factorize(double t, const double* r, bool may_use_schur = true);
  GramSolver::Quality factorize_gram();
  double find_multipliers(double scale);
  double refine(double scale);
  void add_reactions(double* w) const;
  static constexpr double doubtful_above = 1e-9;  // |K'w + phi| over its terms: more than rounding
  double good_enough() const { return request_.exact ? 1e-15 : 1e-12; }
  void take(const Request& request);
  // What contacts ask, see ConstrainedSystem.
  void solve_once(const double* b, double* x) override;
  void solve_refined(const double* b, double* x, double* dw) override {
    respond(b, x, dw != nullptr ? dw : respond_.data());
  }
  void minimize_multiplier_norm(double* x) override { share_out(x); }
  ProjectionReport project_velocities(double t, const double* r, double* v, double* impulses) override {
    return iterate_onto_velocities(t, r, v, impulses);
  }
  Outcome accelerations(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                        double* w) override;
  std::vector<double>& lambda() override { return lambda_; }
  const std::vector<double>& acceleration_scales() const override { return accelerations_; }
  const std::vector<double>& measure_accelerations(const double* w0, const double* b, double scale) override;
  SolveReport& report() override { return last_; }
  const Redundancy& redundancy() const override { return redundancy_; }
  void set_compliance(double size, std::vector<double> weights) override {
    general().set_compliance(size, std::move(weights));
  }
  bool has_switches() const { return contacts_ != nullptr && contacts_->num_events() > 0; }
  bool is_compliant() const { return contacts_ != nullptr && contacts_->sharing().is_compliant(); }
  bool make_compliant() { return contacts_ != nullptr && contacts_->sharing().make_compliant(); }
  Outcome find_friction(double t, const double* r, const double* v, const UniquenessCheck& check, double* w);
  double find_multipliers_and_friction(double scale, double* w);
  std::vector<double> blocks_of_constraints() const;
  void correct(double* rows, double* points);
  void correct_conjugately(bool begins, double* rows, double* points);
  void share_out(double* lambda) const;
  void solve_negative(const double* b, double* x);
  ProjectionReport project_singular_step(double t, double h, double* r, double* step_velocity);
  ProjectionReport settle_step_friction(double t, double h, double* r, double* step_velocity, ProjectionReport report);
  ProjectionReport iterate_onto_velocities(double t, const double* r, double* v, double* sum);
  bool steps_with_friction() const;
  Outcome friction_stalls(double t) const;
  ProjectionReport iterate_onto_positions(double t, double* r, double* sum,
                                          double far = std::numeric_limits<double>::infinity());
  ProjectionReport reach_constraints(double t, double* r);
  Outcome slope_towards(const std::vector<double>& wanted, double t, const double* r, double* d);
  double rounding_floor(const double* r) const;
  bool is_nearest(const double* r, const std::vector<double>& wanted, const double* d) const;
  Outcome explain_stall(double t, double violation) const;
  Outcome check_gradients(double t) const;
  Outcome check_idle_rows(double t, double scale) const;

  // The rank of K, in rank.cpp.
  Outcome decide_rank(double t, const double* r);
  bool decide_rank_again(const double* r);
  Outcome reconsider_rank(double t, const double* r, double scale);
  void adopt_rank(bool has_changed);
  double largest_active(const std::vector<double>& rows, const std::vector<double>& units) const;
  double largest_dependent(const std::vector<double>& rows, const std::vector<double>& units) const;
  Outcome explain_contradiction(double t, const std::vector<double>& rows, const std::vector<double>& sizes,
                                double allowed, const char* unit) const;

  // What is small beside its own neighbourhood, in local_scales.cpp.
  void measure_accelerations(double scale);
  double relative_residual(double largest, double scale);
  double relative_rates(double largest) const;
  double beyond_rounding(const double* r, double violation, double allowed, double times);
  const std::vector<double>& gradient_norms() const;
  std::string describe(const Redundancy::Found& found, const char* verb) const;

  // The factor of another place, in reuse.cpp.
  void make_reuse();
  bool may_reuse() const;
  void note_frames();
  bool reuse(double t);
  bool correct_by_reuse(double* rows, double* points);

  Outcome expand_paths(double t, int passes, std::span<double* const> coefficients, double* smooth_until);
  Outcome check_finite(double t, const double* x) const;

  std::string name_row(std::size_t inner_row) const { return model_.name_row(inner_row); }
  std::size_t num_rows() const { return model_.num_rows(); }

  Model& model_;
  std::vector<double> error_x_, error_v_;     // [3n] of a step, the parts that constraints leave; empty: not asked for
  std::unique_ptr<FrictionSolver> friction_;  // null: constraints are ideal
  std::unique_ptr<ContactModes> contacts_;    // likewise
  Request request_;                           // of the last accelerations
  std::vector<double> accelerations_;  // [neighbourhood] m/s^2, of what cancels in the last accelerations, where …
  bool knows_accelerations_ = false;   // … somebody has asked
  const double* w0_ = nullptr;         // [3n] of the instant at hand
  mutable std::vector<double> norms_;  // [d] scratch
  mutable std::vector<double> of_constraints_;  // [d] scratch of `reactions`: multipliers without friction
  struct {
    std::vector<double> places, at_rest, position, rates, lengths;
  } beyond_;  // scratch of `beyond_rounding`
  struct Direction {
    std::vector<double> d, q;  // [d] of multipliers, and S d
  };
  struct {
    std::vector<Direction> directions;
    std::vector<double> y;  // [3n]
    std::size_t num_kept = 0, next = 0;
  } conjugate_;                               // of `correct_conjugately`
  std::vector<double> respond_;               // [3n] scratch
  const Ordering ordering_;                   // wanted
  std::unique_ptr<SchurSolver> schur_;        // null: the sparse factor of all alone
  std::unique_ptr<GramSolver> solver_;        // the sparse factor of all; null where only `schur_` was needed
  bool is_of_schur_ = false;                  // the last factor is that of `schur_`
  std::unique_ptr<Reuse> reuse_;              // null: never
  double allowed_error_ = 0.0;                // of dw in the M-norm, inside a step; 0: rounding
  bool has_old_factor_ = false;               // not of the K at hand
  std::optional<std::size_t> factor_frames_;  // of lines, where it was made; see Constraints::frames
  std::vector<double> correction_;            // [3n] scratch of `correct_by_reuse`
  bool linearises_cheaply_;                   // a factorization costs no more than two solves
  Redundancy redundancy_;
  double suspect_below_;                // reciprocal condition of S
  std::vector<double> gradient_norms_;  // [d] at the last decision, where rows depend

  // The last instant.
  bool is_factorized_ = false;
  SolveReport last_;
  std::vector<double> blocks_;                      // K
  std::vector<double> dw_;                          // [3n] w - w0 = M^-1 K lambda
  std::vector<double> right_side_, lambda_, rows_;  // [d] phi + K'w0; multipliers; scratch
  struct StepMultipliers {
    std::vector<double> sum;           // of this step's iterations
    std::vector<double> last, before;  // of the last two steps, over h^2; 0 after a jump of
    std::size_t frames = 0;            // the unit vectors of lines
    double last_h = std::numeric_limits<double>::max(), before_h = last_h;  // s, of those steps
  } step_multipliers_;
  std::unique_ptr<PathSeries> path_series_;  // made where somebody asks, if it serves
  std::unique_ptr<MotionSeries> series_;     // else
  struct {
    std::vector<double> blocks;           // K that is remembered; empty: none, or rows depended
    std::vector<double> x, y, move;       // [d], [d], [3n] scratch
  } before_;                              // where K may lose rank
  std::vector<double> lambda_series_;     // [d] lambda_k of the last order
  std::vector<double> right_side_of_qr_;  // [d] where QR takes part
  std::vector<double> step_start_;        // [3n] where rows depend
};

}  // namespace tanor
