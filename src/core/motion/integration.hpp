#pragma once

#include <functional>
#include <memory>

#include <tanor/motion.hpp>

#include "motion/drive_control.hpp"
#include "motion/jump_steps.hpp"
#include "motion/rounding.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_configurations.hpp"
#include "motion/snapshot.hpp"
#include "motion/step_control.hpp"
#include "motion/step_trial.hpp"
#include "motion/stiff_steps.hpp"
#include "motion/turn_meter.hpp"

namespace tanor::detail {

/// Advances a state through time: a scheme, the lengths of its steps, and the events and singular configurations on the
/// way.
class Integration {
 public:
  /// Writes rejected steps, events, rank changes, singular configurations and the length of the last step into
  /// `report`. `method` is not Auto.
  Integration(Method method, const IntegrationOptions& options, Mechanics& mechanics, MotionReport* report);

  /// Called after every step, whose end is `state`.
  using Taken = std::function<void(const StepResult&)>;
  /// Called for the user after every step; returns false to stop there. A fixed step that was split or met events
  /// counts as one step here.
  using Observer = std::function<bool(const MotionReport&)>;

  const Scheme& scheme() const { return *scheme_; }
  /// Returns how this motion asks for accelerations.
  Request request(Gradients gradients) const { return options_.request(gradients); }
  /// Returns true if steps turned out stiff and another method took over; `explain_stiffness` tells why.
  bool is_stiff() const { return stiff_steps_.is_stiff(); }
  std::string explain_stiffness() const { return stiff_steps_.explain(); }
  /// Returns true if `state` has its acceleration, from a scheme that leaves one or from extrapolation.
  bool knows_acceleration() const { return trial_.knows_acceleration(); }

  /// Begins a motion, or resumes one. Call one of these when `state` is complete and the mechanics has solved there
  /// last.
  void begin();
  void resume(const Snapshot& snapshot);
  /// Returns true if the state is being extrapolated past a singular configuration. After restoring such a state, call
  /// `return_to_constraints` in place of `linearise`. K is unreliable there, so that the system is linearised at the
  /// previous state.
  bool is_extrapolating() const { return singular_.is_extrapolating(); }
  Outcome return_to_constraints();

  /// The events that the user looks for on the way.
  Watch& watch() { return trial_.watch; }
  const Watch& watch() const { return trial_.watch; }
  /// The vectors that must not vanish on the way.
  VanishingArms& arms() { return trial_.arms; }

  /// Advances from state.t to exactly t_end, or to an event that stops there. On a failure `state` stays at the last
  /// good step, but the mechanics does not. An adaptive scheme needs `next_step` > 0.
  Outcome advance(double t_end, const Taken& taken, const Observer& observer);

  /// Returns how far the last fixed step turned the motion, rad; 0 if that is not known or the step moved too little.
  double turn() const;

  /// Returns a warning that tells what fixed steps passed over; empty if that is little.
  std::string explain_missed();

  /// Writes to a snapshot, or restores from it, what the next step depends on besides the state. After `restore` the
  /// owner completes the state from its points, for which the mechanics solves once; `resume` then puts back what that
  /// solve may have changed in its last bits.
  void write(Snapshot* snapshot);
  /// Writes the part that does not depend on how points are distributed over processes.
  void write_progress(Snapshot* snapshot) const;
  void restore(const Snapshot& snapshot);
  /// Restores the memory. Call this when `state` has its points, before the solve that completes it.
  void restore_memory(const Snapshot& snapshot);
  /// Restores what the last good step left behind, after attempts that failed. Call this both before and after the
  /// solve that completes `state` again.
  void restore_good_memory();

  State state;             ///< completed by the owner before the first step
  double next_step = 0.0;  ///< s, first length to try (adaptive schemes); 0 if not known yet

 private:
  using Cut = JumpSteps::Cut;

  void exchange_memory(Memory& memory);
  void exchange_states(Memory& memory, bool* is_after_rejection);
  void keep_memory();

  Outcome advance_adaptively(double t_end, const Taken& taken, const Observer& observer);
  Outcome extrapolate_adaptively(double t_end, const Taken& taken);
  Outcome step_adaptively(double t_end, const Taken& taken);
  Outcome reject(const StepAttempt& attempt, const Cut& cut, double h, double resolution);
  Outcome look_for_corner(double h, double* clear);
  Outcome cross_corner(double t, const Taken& taken);
  void take_scheme(Method method, double first_step);
  Outcome look_for_stiffness(double t_end);
  Outcome advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer);
  Outcome step_or_split(double t, int splits_left, const Taken& taken);
  Outcome step_too_small(double resolution, Outcome reason);
  Outcome find_end_ahead(double resolution);
  Outcome explain_end(double within, Outcome reason);
  Outcome find_collision(double within);
  double longest_step() const;
  void take_trial(const StepAttempt& attempt, const Taken& taken);

  Method method_;
  IntegrationOptions options_;
  Mechanics& mechanics_;
  MotionReport& report_;
  std::unique_ptr<Scheme> scheme_;
  StepControl control_;
  JumpSteps jumps_;
  Cut cut_;          // to try next from the present state
  Outcome refusal_;  // reason of the last failed try since the last step
  DriveControl drives_;
  SingularConfigurations singular_;
  Rounding rounding_;
  StiffSteps stiff_steps_;
  StepTrial trial_;
  TurnMeter turns_;
  bool has_stopped_ = false;         // true if an event stopped the advance before its end
  std::vector<double> good_memory_;  // memory at `state` if several modes of friction are possible; else empty
  struct {
    double begin = 0.0, end = 0.0;
  } last_advance_;  // s, of the last advance in equal steps
};

}  // namespace tanor::detail
