#pragma once

#include <span>
#include <vector>

#include "dynamics/roles.hpp"
#include "friction/contact_choices.hpp"

namespace tanor::detail {

/// Stick and slip of contacts (docs/friction.md): exact Coulomb friction with events.
///
/// A contact sticks as long as |lambda_t| <= mu_s |N|, and slides until its sliding velocity vanishes. At rest the law
/// holds on the acceleration level: lambda_t in -mu_s |N| Sgn(a_t).
class ContactModes final : public EventFunctions {
 public:
  /// Both arguments must outlive this object.
  ContactModes(ContactState& state, FrictionSolver& friction)
      : work_(state.work), model_(state.model), friction_(friction), state_(state) {}

  // ---- the modes ----

  /// Chooses the modes at a start and computes their accelerations [3n]. Changes v where contacts are put to rest
  /// exactly.
  Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to);
  std::size_t num_events() const override { return state_.num_switches; }
  void evaluate_events(const Kinematics& at, const Reactions& found, double* values) override;
  void shape_events(const Reactions& found, const double* values, double* shapes) const override;
  Outcome switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                           const Request& request, const AccelerationOutput& to) override {
    return switch_guides(t, r, v, which, {}, request, to);
  }
  Outcome switch_guides(double t, const double* r, double* v, std::span<const std::size_t> which,
                        std::span<const GuideChange> guides, const Request& request, const AccelerationOutput& to);
  Power work_of_switch() const override { return work_of_rest_; }
  std::vector<int> discrete_state() const override { return state_.discrete_state(); }
  std::string describe_change(std::span<const int> before) const override { return state_.describe_change(before); }
  void restore_discrete_state(std::span<const int> state) override { state_.restore_discrete_state(state); }
  /// Notes that a step to (t, r, v) was accepted.
  void accept(double t, const double* r, const double* v);

  void exchange_memory(Memory& memory);
  /// Returns NotConverged, with the contact's name, if one of those that `at` has at rest misses its law.
  Outcome check_rest(const ModeSwitch& at) const;

 private:
  Outcome choose(ModeSwitch at);
  Outcome put_to_rest(ModeSwitch* at);
  template <class Change>
  bool change_some(const Change& change);
  bool let_slide(const double* v, double times, ModeSwitch* at);
  bool let_pass(const double* v, double times, ModeSwitch* at);
  bool keep_from_rest(ModeSwitch* at);
  double speed_of_rest(const ModeSwitch& at, const double* v) const;
  bool is_little(const std::vector<double>& before, const double* v, double little, double own) const;
  Power work_of_impulses(const double* r, const std::vector<double>& impulses) const;
  bool bring_along(ModeSwitch* at);
  void forget_slow_directions(const ModeSwitch& at);
  Outcome count_islands(const ModeSwitch& at, std::vector<ContactChoice>* choices);
  Outcome search(const ModeSwitch& at, bool shared_loads, std::vector<char>* are_counted);
  Outcome finish(const ModeSwitch& at, const std::vector<char>& are_counted);
  Outcome keep_moving(const ModeSwitch& at);
  std::vector<char> find_many_on_surfaces(const ModeSwitch& at) const;

  Workspace& work_;
  const Model& model_;
  FrictionSolver& friction_;
  ContactState& state_;
  Power work_of_rest_;  // J, at the last switch
};

}  // namespace tanor::detail
