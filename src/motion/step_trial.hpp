#pragma once

#include <memory>

#include <tanor/motion.hpp>

#include "motion/drive_control.hpp"
#include "motion/events.hpp"
#include "motion/passages.hpp"
#include "motion/scheme.hpp"
#include "motion/singular_configurations.hpp"
#include "motion/watch.hpp"

namespace tanor {

/// The outcome of one attempt to go on.
struct StepAttempt {
  StepResult step;
  double error = 0.0;          ///< of the whole step, also where an event cut it short
  double part = 1.0;           ///< below 1: to make instead, since it passes forces unseen
  bool has_surprised = false;  ///< by a singular configuration
  bool is_extrapolated = false;
  bool has_stopped = false;   ///< at an event of the user's
  bool has_switched = false;  ///< equations at its end; on a failed outcome no other step helps

  bool is_good() const { return step.outcome.ok() && error <= 1.0 && part >= 1.0 && !has_surprised; }
};

/// Attempts to go on from the state of a motion: by its scheme, or along the last two states past a singular
/// configuration. An attempt ends at the first event on its way; whether it is taken is for others to decide.
class StepTrial {
 public:
  /// What a motion goes on with.
  struct Motion {
    State& state;
    const std::unique_ptr<Scheme>& scheme;
    DriveControl& drives;
    SingularConfigurations& singular;
  };

  /// All outlive it. Writes into `report` a warning where fixed steps pass a force unseen.
  StepTrial(const IntegrationOptions& options, Mechanics& mechanics, const Motion& motion, MotionReport* report);

  /// A motion begins at its state.
  void begin();
  /// Tries a step of the scheme, to t or to the first event on the way.
  StepAttempt step(double t, bool may_surprise);
  /// The same. A failed attempt leaves the state before alone where the next step may be extrapolated from it.
  StepAttempt step_and_remember(double t, bool may_surprise);
  /// Goes on along the last two states, past a singular configuration or near it. Events on the way are met at the end.
  StepAttempt extrapolate(double t, bool takes_least_error = false);
  /// Takes the scheme's own step past a singular configuration that is foreseen.
  StepAttempt pass(double t);
  /// The motion's state has its acceleration. It comes from a scheme that leaves one, or was extrapolated.
  bool knows_acceleration() const {
    return motion_.scheme->knows_acceleration() || motion_.singular.is_extrapolating();
  }

  State state;             ///< where the last attempt ended; after a step that was taken: the state before it, if …
  bool is_before = false;  ///< … no other was tried since
  Events events;           ///< where equations change
  Watch watch;             ///< the events that the user looks for

 private:
  void look_between(StepAttempt* attempt);
  void look_out(StepAttempt* attempt);

  IntegrationOptions options_;
  Mechanics& mechanics_;
  const Motion motion_;
  MotionReport& report_;
  Passages passages_;
  State beyond_;  // of extrapolations; made by the first of them
};

}  // namespace tanor
