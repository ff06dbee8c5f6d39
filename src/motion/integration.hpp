#pragma once

#include <functional>
#include <memory>

#include <tanor/motion.hpp>

#include "motion/events.hpp"
#include "motion/scheme.hpp"
#include "motion/step_control.hpp"

namespace tanor {

/// A state on its way through time: a scheme, the lengths of its steps, and the events on the way.
class Integration {
 public:
  /// Counts steps that were rejected, events and the length of the last step into `report`; `method` is not Auto.
  Integration(Method method, const MotionOptions& options, Mechanics& mechanics, MotionReport* report);

  /// After every step, whose end is `state`.
  using Taken = std::function<void(const StepResult&)>;
  /// After every step, for the user; false: stop there. A fixed step that was split or met events is one step here.
  using Observer = std::function<bool(const MotionReport&)>;

  const Scheme& scheme() const { return *scheme_; }

  /// From state.t to exactly t_end; on a failure `state` stays at the last good step, the mechanics does not. An
  /// adaptive scheme needs `next_step` > 0.
  Outcome advance(double t_end, const Taken& taken, const Observer& observer);

  /// What the next step depends on beside the state, to and from a snapshot.
  void write(Snapshot* snapshot) const;
  void restore(const Snapshot& snapshot);

  State state;             ///< to be completed by the owner before the first step
  State trial;             ///< of the same sizes, equal where nothing moves
  double next_step = 0.0;  ///< s, adaptive schemes: the first one to try; 0: not known yet

 private:
  Outcome advance_adaptively(double t_end, const Taken& taken, const Observer& observer);
  Outcome advance_in_equal_steps(double t_end, const Taken& taken, const Observer& observer);
  Outcome step_or_split(double t, int splits_left, const Taken& taken);
  Outcome step_too_small(double resolution, const Outcome& reason) const;
  void take_trial(const StepResult& step, const Taken& taken);

  Method method_;
  MotionOptions options_;
  Mechanics& mechanics_;
  MotionReport& report_;
  std::unique_ptr<Scheme> scheme_;
  StepControl control_;
  Events events_;
  double advance_begin_ = 0.0, advance_end_ = 0.0;  // of the last advance in equal steps
};

}  // namespace tanor
