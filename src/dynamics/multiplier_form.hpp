#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynamics/contact_choice.hpp"
#include "dynamics/equations_of_motion.hpp"
#include "dynamics/forward_dynamics.hpp"
#include "dynamics/friction_stage.hpp"
#include "dynamics/gradient_rank.hpp"
#include "dynamics/held_places.hpp"
#include "dynamics/implicit_form.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/model.hpp"
#include "dynamics/multiplier_series.hpp"
#include "dynamics/point_roles.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/step_projection.hpp"

namespace tanor {

/// The equations of motion in the positions r themselves, with Lagrange multipliers: the paper's normal form (31),
/// (25). Wires together the objects that answer.
class MultiplierForm final : public EquationsOfMotion,
                             private EventFunctions,
                             private StickingContacts,
                             private ContactModes {
 public:
  MultiplierForm(Model& model, const SolverOptions& options);

  std::size_t size() const override { return 3 * model_.num_points(); }
  bool keeps_variables() const override { return true; }
  bool has_work() const override { return model_.is_rheonomic() || model_.forces.has_work() || friction_ != nullptr; }
  const Parallel& parallel() const override { return model_.parallel; }
  PointTolerances point_tolerances() const override {
    return {model_.scales.position_tolerances(), model_.scales.velocity_tolerances(), model_.scales.accelerations()};
  }

  void prescribe(double t, double* r, double* v) override { model_.prescribe(t, r, v); }
  Outcome linearise(double t, const double* r) override { return linearization_.update(t, r); }
  Outcome accelerations(const Kinematics& at, const Request& request, double* w) override {
    request_ = request;
    return dynamics_.solve(at, request, w);
  }
  const SolveReport& last_solve() const override { return last_; }
  std::size_t rank() const override { return model_.rank; }
  Power power(const double* r, const double* v) override;
  ProjectionReport project_positions(double t, double* r, Turn turn = Turn::Small) override {
    return projector_.project_positions(t, r, turn);
  }
  ProjectionReport project_velocities(double t, const double* r, double* v) override {
    return projector_.project_velocities(t, r, v);
  }
  ErrorRatios error_ratios(double t, const StepErrors& errors, double atol, double rtol) override;
  void exchange_memory(Memory& memory) override;

  StepProjector* step_projector() override { return &steps_; }
  InexactSolves* inexact_solves() override { return linearization_.reuse(); }
  RankMonitor* rank_monitor() override { return model_.may_lose_rank ? &gradient_rank_ : nullptr; }
  /// Friction remembers what it was asked last: there nobody asks for more.
  RoundingGroups* rounding_groups() override { return friction_ == nullptr ? &rounding_ : nullptr; }
  ForcePassages* force_passages() override {
    return model_.may_be_passed(model_.constraint_passages) ? &passages_ : nullptr;
  }
  SeriesExpansion* series() override;
  std::string why_no_series() const override {
    return series_ != nullptr ? series_->obstacle() : MultiplierSeries::find_obstacle(model_);
  }
  DriveMonitor* drives() override { return !model_.drives.empty() ? &drives_ : nullptr; }
  EventFunctions* events() override { return num_switches_ > 0 ? this : nullptr; }
  ImplicitFormulation* implicit_formulation() override { return friction_ == nullptr ? &implicit_ : nullptr; }

  StartReport start(double t, double* r, double* v, StartMode mode) override;
  ProjectionReport project_point_positions(double t, double* r) override;
  ProjectionReport project_point_velocities(double t, const double* r, double* v) override;
  Outcome set_state(double t, const double* r, const double* v, double* x, double* x_dot) override;
  void write_points(double t, const double* x, const double* x_dot, const double* x_ddot, double* r, double* v,
                    double* w) override;
  Outcome begin(double t, const double* r, double* v, const Request& request, double* w) override;
  void recentre(double t, double* r, double* v, double*) override {
    if (friction_ == nullptr) return;
    if (num_switches_ > 0) accept_places(t, r);
    set_sliding_speeds();
    friction_->laws().keep_senses(v);
  }
  void resume(const Counters& counters, const PhaseTimes& times) override;
  Energy energy(double, const double* r, const double* v) override { return model_.energy(r, v); }
  void reactions(double* eta) override { dynamics_.write_reactions(eta); }
  void friction_forces(double* tau) const override;
  void describe(PlanSummary* plan) const override;

  /// Whatever is solved at the configuration of the last linearisation.
  Linearization& linearization() { return linearization_; }
  const Linearization& linearization() const { return linearization_; }
  GradientRank& gradient_rank() { return gradient_rank_; }
  /// lambda [d] of the last accelerations.
  const std::vector<double>& multipliers() const { return dynamics_.multipliers(); }
  /// tau [3n] of the last accelerations, but what the rows of contacts that stick hold.
  void given_friction_forces(double* tau) const;
  /// The law at lambda [3n], at the last accelerations; contacts that stick have none.
  void evaluate_friction(const double* lambda, double* tau);
  /// A contact whose reaction dependent constraints share by convention, at the last linearisation; empty: there is
  /// none.
  std::string find_undetermined_reaction() const;

  /// Predicted flops of one evaluation and solve.
  double predicted_flops() const;
  /// Of S: "natural" where elimination makes no fill, "amd", …
  std::string ordering() const;

 private:
  friend struct Tampering;  // the tests' hand in the works: every corruption must be caught
  // Contacts that slide or stick, in contacts.cpp.
  std::size_t num_events() const override { return num_switches_; }
  void evaluate_events(double t, const double* r, const double* v, double* values) override;
  void shape_events(const double* values, double* shapes) const override;
  Outcome switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                           const Request& request, double* w) override;
  Power work_of_switch() const override { return work_of_rest_; }
  std::vector<int> discrete_state() const override;
  void restore_discrete_state(std::span<const int> state) override;
  // StickingContacts
  std::size_t num_sticking() const override { return friction_->num_sticking(); }
  bool share_a_load() const override;
  std::vector<double> compliance_weights() const override;
  // ContactModes
  void prepare(const double* r, const double* v) override;
  void add_verdict(FrictionReport* report) const override;
  Outcome settle_contacts(double t, const double* r, double* v, double* w);
  void restore_senses(const double* r, const double* v);
  double sliding_threshold(std::size_t contact) const;
  double speed_at(std::size_t contact) const;
  double acceleration_at(std::size_t contact) const;
  Power work_of_impulses(const double* r, const double* v, const std::vector<double>& impulses);
  Outcome put_to_rest(double t, const double* r, double* v, std::vector<char>* at_rest);
  Outcome choose_modes(double t, const double* r, double* v, std::vector<char> at_rest,
                       const std::vector<std::size_t>& releases, const std::vector<char>& has_changed, double* w);
  Outcome settle_modes(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                       const std::vector<std::size_t>& releases, const std::vector<char>& wanted,
                       const std::vector<ContactChoice>& choices, double* w);
  std::vector<char> find_many_on_surfaces(const std::vector<char>& at_rest, const std::vector<char>& wanted) const;
  Outcome check_rest(double t, const double* r, const double* v, const double* w, const std::vector<char>& at_rest);
  void share_again(const std::vector<double>& loads);
  void release(std::size_t contact);
  // What contacts at rest choose, in contact_choice.cpp.
  std::vector<ContactChoice> list_choices(const std::vector<char>& at_rest, const std::vector<char>& wanted,
                                          std::size_t most_contacts) const;
  void reduce(double t, const double* r, const double* v, std::vector<ContactChoice>* choices);
  void solve_choice(std::vector<char> released, std::size_t most_modes, ContactChoice* choice) const;
  void guess_multipliers(double t, const double* r, const double* v, const std::vector<ContactChoice>& choices);
  Outcome explain_choice(double t, const ContactChoice& choice) const;
  void choose(const std::vector<char>& released, std::size_t most_modes, ContactChoice* choice) const;
  void find_share(ContactChoice* choice) const;
  Outcome take_choices(double t, const double* r, const std::vector<char>& at_rest, bool all,
                       std::vector<ContactChoice>* choices);
  Outcome count_choices(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                        std::span<const std::size_t> releases, const std::vector<char>& wanted,
                        std::size_t most_contacts, std::vector<ContactChoice>* choices);
  Outcome judge_many(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                     const std::vector<char>& wanted);
  bool set_limits(const std::vector<ContactChoice>& choices);
  void note_verdict(Uniqueness uniqueness, const std::string& reason);
  void set_sliding_speeds();
  void accept_places(double t, const double* r);
  void forget_compliance() { linearization_.rank_factor().forget_compliance(); }
  bool is_compliant() const { return linearization_.rank_factor().is_compliant(); }
  std::size_t num_rows() const { return model_.num_rows(); }

  Model& model_;
  SolveReport last_;
  Linearization linearization_;
  Residuals residuals_;
  Projector projector_;
  ForwardDynamics dynamics_;
  StepProjection steps_;
  GradientRank gradient_rank_;
  PointPassages passages_;
  PointDrives drives_;
  PointRounding rounding_;
  ImplicitMultiplierForm implicit_;
  std::unique_ptr<MultiplierSeries> series_;   // made where somebody asks
  std::vector<double> error_x_, error_v_;      // [3n] of a step, the parts that constraints leave
  std::vector<double> rows_, points_;          // [d], [3n] scratch
  std::unique_ptr<FrictionStage> friction_;    // null: constraints are ideal
  std::unique_ptr<HeldPlaces> held_;           // likewise
  std::size_t num_switches_ = 0;               // contacts that may stick
  Request request_;                            // of the last accelerations, or of what asks for them
  Uniqueness verdict_ = Uniqueness::NotAsked;  // of all modes, since they were counted last
  std::string verdict_reason_;
  static constexpr int softness_steps = 1 << 20;  // an octave
  // A share is set to 1e-7 of itself: nearer than this to its limit a contact is held until `overload` above it.
  static constexpr double to_spare = 1e-6, overload = 4e-6;
  std::vector<char> overloads_;  // [contact] held until `overload` above its limit
  double limit_factor(std::size_t contact) const {
    return !overloads_.empty() && overloads_[contact] != 0 ? 1.0 + overload : 1.0;
  }
  std::vector<int> softness_;         // [contact] 0: softest; empty: all are alike
  std::vector<double>& lambda_;       // of `dynamics_`
  Power work_of_rest_;                // J, of the last switch
  std::vector<int> restored_;         // discrete state whose senses are still to be found
  std::vector<double> contact_rows_;  // [d] scratch
};

}  // namespace tanor
