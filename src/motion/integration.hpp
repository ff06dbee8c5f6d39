#pragma once

#include <functional>
#include <memory>

#include <tanor/motion.hpp>

#include "motion/drive_control.hpp"
#include "motion/rounding.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_configurations.hpp"
#include "motion/snapshot.hpp"
#include "motion/step_control.hpp"
#include "motion/step_trial.hpp"
#include "motion/stiff_steps.hpp"
#include "motion/turn_meter.hpp"

namespace tanor {

/// A state on its way through time: a scheme, the lengths of its steps, and the events and singular configurations on
/// the way.
class Integration {
 public:
  /// Writes into `report`: rejected steps, events, rank changes, singular configurations and the length of the last
  /// step. `method` is not Auto.
  Integration(Method method, const IntegrationOptions& options, Mechanics& mechanics, MotionReport* report);

  /// After every step, whose end is `state`.
  using Taken = std::function<void(const StepResult&)>;
  /// After every step, for the user; false: stop there. A fixed step that was split or met events is one step here.
  using Observer = std::function<bool(const MotionReport&)>;

  const Scheme& scheme() const { return *scheme_; }
  /// How this motion asks for accelerations.
  Request request(Gradients gradients) const { return options_.request(gradients); }
  /// Steps turned out stiff on the way, and another method took over for a reason.
  bool is_stiff() const { return stiff_steps_.is_stiff(); }
  std::string explain_stiffness() const { return stiff_steps_.explain(); }
  /// `state` has its acceleration. It comes from a scheme that leaves one, or was extrapolated.
  bool knows_acceleration() const { return trial_.knows_acceleration(); }

  /// Call one of these when `state` was completed, where the mechanics has solved last: a motion begins, or goes on.
  void begin();
  void resume(const Snapshot& snapshot);
  /// Call `return_to_constraints` in place of `linearise` after restoring a state that is being extrapolated past a
  /// singular configuration: K is unreliable there, so the system is linearised at the state before.
  bool is_extrapolating() const { return singular_.is_extrapolating(); }
  Outcome return_to_constraints();

  /// The events that the user looks for on the way.
  Watch& watch() { return trial_.watch; }
  const Watch& watch() const { return trial_.watch; }

  /// Goes from state.t to exactly t_end, or to an event that stops there. On a failure `state` stays at the last good
  /// step, the mechanics does not. An adaptive scheme needs `next_step` > 0.
  Outcome advance(double t_end, const Taken& taken, const Observer& observer);

  /// How far the last fixed step turned the motion, rad; 0: it moved too little to tell.
  double turn() const;

  /// A warning that says what fixed steps passed over; empty: nothing to speak of.
  std::string explain_missed() const;

  /// What the next step depends on beside the state, to and from a snapshot. After `restore` the owner completes the
  /// state from its points, where the mechanics solves once; `resume` then puts back what that solve may have changed
  /// in its last bits.
  void write(Snapshot* snapshot);
  /// The part of it that does not depend on how points are spread over processes.
  void write_progress(Snapshot* snapshot) const;
  void restore(const Snapshot& snapshot);
  /// Call this when `state` has its points, before that solve.
  void restore_memory(const Snapshot& snapshot);
  /// Restores what the last good step left behind, after attempts that failed. Call this before the solve that
  /// completes `state` again, and after it.
  void restore_good_memory();

  State state;             ///< to be completed by the owner before the first step
  double next_step = 0.0;  ///< s, adaptive schemes: the first one to try; 0: not known yet

 private:
  void exchange_memory(Memory& memory);
  void exchange_states(Memory& memory, bool* is_after_rejection);
  void keep_memory();

  Outcome advance_adaptively(double t_end, const Taken& taken, const Observer& observer);
  Outcome extrapolate_adaptively(double t_end, const Taken& taken);
  Outcome step_adaptively(double t_end, const Taken& taken);
  void take_scheme(Method method, double first_step);
  Outcome look_for_stiffness(double t_end);
  Outcome advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer);
  Outcome step_or_split(double t, int splits_left, const Taken& taken);
  Outcome step_too_small(double resolution, Outcome reason);
  Outcome find_end_ahead(double resolution);
  Outcome find_collision(double within);
  double longest_step() const;
  void take_trial(const StepAttempt& attempt, const Taken& taken);

  Method method_;
  IntegrationOptions options_;
  Mechanics& mechanics_;
  MotionReport& report_;
  std::unique_ptr<Scheme> scheme_;
  StepControl control_;
  Outcome refusal_;  // why a try since the last step failed, where it did
  DriveControl drives_;
  SingularConfigurations singular_;
  Rounding rounding_;
  StiffSteps stiff_steps_;
  StepTrial trial_;
  TurnMeter turns_;
  bool has_stopped_ = false;         // the advance, before its end
  std::vector<double> good_memory_;  // at `state`, where contacts switch; else empty
  struct {
    double begin = 0.0, end = 0.0;
  } last_advance_;  // s, in equal steps
};

}  // namespace tanor
