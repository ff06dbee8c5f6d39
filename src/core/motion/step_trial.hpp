#pragma once

#include <memory>

#include <tanor/motion.hpp>

#include "motion/corners.hpp"
#include "motion/drive_control.hpp"
#include "motion/events.hpp"
#include "motion/jump_steps.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_configurations.hpp"
#include "motion/step_sampler.hpp"
#include "motion/vanishing_arms.hpp"
#include "motion/watch.hpp"

namespace tanor::detail {

/// The outcome of one attempt to continue.
struct StepAttempt {
  StepResult step;
  double error = 0.0;          ///< error of the whole step, even if an event cut it short
  double part = 1.0;           ///< part of the step to make instead; below 1 if the step passes forces unseen
  PointPath::Jump jump;        ///< where a force jumps first in the step, if one does
  bool has_surprised = false;  ///< true if a singular configuration was not foreseen
  bool is_extrapolated = false;
  bool has_stopped = false;   ///< true if it stopped at an event of the user's, or where the motion ends
  bool has_switched = false;  ///< true if equations switched at its end; if the outcome failed, no other step helps

  bool is_good() const { return step.outcome.ok() && error <= 1.0 && part >= 1.0 && !jump.exists() && !has_surprised; }
};

/// Attempts to continue from the state of a motion: by its scheme, or along the last two states past a singular
/// configuration. An attempt ends at the first event. The caller decides whether it is taken.
class StepTrial {
 public:
  /// The objects with which a motion continues.
  struct Motion {
    State& state;
    const std::unique_ptr<Scheme>& scheme;
    DriveControl& drives;
    SingularConfigurations& singular;
  };

  /// All arguments outlive the object. Writes a warning into `report` if fixed steps pass a force unseen.
  StepTrial(const IntegrationOptions& options, Mechanics& mechanics, const Motion& motion, MotionReport* report);

  /// Begins a motion at its state.
  void begin();
  /// Looks of a step for forces between those of its scheme, or none: a force jumps in it.
  enum class Looks { Between, None };
  /// Tries a step of the scheme, to t or to the first event on the way.
  StepAttempt step(double t, bool may_surprise, Looks looks = Looks::Between);
  /// Tries a fixed step to t. One in which a force jumps ends right before that, and the next one right behind it.
  StepAttempt step_to_jump(double t, bool may_surprise, JumpSteps* jumps);
  /// Does as `step`. A failed attempt preserves the previous state if the next step may be extrapolated from it.
  StepAttempt step_and_remember(double t, bool may_surprise, Looks looks = Looks::Between);
  /// Continues along the last two states, past a singular configuration or near it. Events on the way are met at the
  /// end.
  StepAttempt extrapolate(double t, bool takes_least_error = false);
  /// Takes the scheme's own step past a singular configuration that is foreseen.
  StepAttempt pass(double t);
  /// Crosses the corner of guides that is right ahead of a step to t.
  StepAttempt cross(double t);
  /// Computes the acceleration of the motion's state, where the mechanics is linearised, unless it is known.
  Outcome find_acceleration();
  /// Names a force that jumps so many seconds ahead of the motion's state, which knows its acceleration.
  Outcome find_jump(double within);
  /// Returns true if the motion's state has its acceleration, from a scheme that leaves one or from extrapolation.
  bool knows_acceleration() const {
    return motion_.scheme->knows_acceleration() || motion_.singular.is_extrapolating();
  }

  State state;             ///< end of the last attempt; after a step that was taken, the state before it if …
  bool is_before = false;  ///< … no other attempt was made since
  Events events;           ///< events where equations change
  Watch watch;             ///< the events that the user looks for
  Corners corners;         ///< of guides
  VanishingArms arms;      ///< vectors that must not vanish
  Outcome end;             ///< why the motion ends where the last attempt does; ok if it goes on

 private:
  void look_between(StepAttempt* attempt);
  void detect_user_events(StepAttempt* attempt);
  void end_before_arms_vanish(StepAttempt* attempt);
  void approach(const VanishingArms::Found& arm, double left_at_begin, StepAttempt* attempt);
  void step_again(const State& from, double t, StepAttempt* attempt);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  const Motion motion_;
  MotionReport& report_;
  StepSampler sampler_;
  State beyond_;  // end of an extrapolation; the first one makes it
};

}  // namespace tanor::detail
