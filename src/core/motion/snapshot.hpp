#pragma once

#include <limits>
#include <vector>

#include <tanor/motion.hpp>

namespace tanor::detail {

/// The truth of the condition of an event.
struct Truth {
  bool is_true = false;                                            ///< when it was last looked at
  bool is_given_up = false;                                        ///< it is looked at no more
  double last_passage = std::numeric_limits<double>::quiet_NaN();  ///< s
  double looks = 0.0;                                              ///< number of evaluations
};

/// Everything that another simulation of the same system needs to continue from here.
struct Snapshot {
  double time = 0.0;               ///< s
  std::vector<double> positions;   ///< 3n, m, in the user's order
  std::vector<double> velocities;  ///< 3n, m/s
  std::vector<Extreme> extremes;   ///< of observables, in their order
  std::vector<Passage> passages;   ///< of events
  std::vector<Truth> truths;       ///< [event]
  std::vector<std::size_t>
      taken;            ///< what events took out: list, index and member (or none, the largest number) of each
  MotionReport report;  ///< counts, times, works and extremes so far

  // These members are what the next step depends on besides the state. The defaults are those of a start.
  double next_step = 0.0;            ///< s, adaptive methods; 0 if not known yet
  double last_error = 1e-4;          ///< error of the last step, over the tolerance
  double advance_begin = 0.0;        ///< s, fixed steps: an advance stopped before `advance_end` continues with …
  double advance_end = 0.0;          ///< … the steps that it had from `advance_begin` on
  std::vector<int> discrete_state;   ///< which contacts slip and which way, …
  std::vector<double> event_slopes;  ///< 1/s, … and how the event functions fell in the last step; empty if unknown
  std::vector<double> memory;        ///< what the method and the solvers keep from step to step
  std::vector<double> drive_memory;  ///< how far functions of time were examined; empty at the start of a motion
  std::vector<double> singular_memory;  ///< what is known of configurations where K loses rank; empty if K keeps it
  std::vector<double> rounding_memory;  ///< how well accelerations are known, see rounding.hpp; empty if not measured
  std::vector<double> stiff_memory;     ///< whether explicit steps turned out stiff; empty if auto did not choose
  std::vector<double> state_before;     ///< beginning of the last step if it may be extrapolated from; else empty
};

}  // namespace tanor::detail
