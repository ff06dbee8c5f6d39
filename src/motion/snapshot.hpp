#pragma once

#include <vector>

#include <tanor/motion.hpp>

namespace tanor {

/// All that another simulation of the same system needs to go on from here.
struct Snapshot {
  double time = 0.0;               ///< s
  std::vector<double> positions;   ///< 3n, m, in the user's order
  std::vector<double> velocities;  ///< 3n, m/s
  MotionReport report;             ///< its counts, times, works and extremes go on

  // What the next step depends on beside the state; the defaults are those of a start.
  double next_step = 0.0;            ///< s, adaptive methods; 0: not known yet
  double last_error = 1e-4;          ///< of the last step, over the tolerance
  double advance_begin = 0.0;        ///< s, fixed steps: an advance that was stopped before `advance_end` goes on with
  double advance_end = 0.0;          ///< the steps it had from `advance_begin` on
  std::vector<int> discrete_state;   ///< which contacts slip and which way, …
  std::vector<double> event_slopes;  ///< 1/s, how what decides on them fell in the last step; empty: not known
  std::vector<double> memory;        ///< what the method and the solvers keep from step to step
  std::vector<double> drive_memory;  ///< how far functions of time were looked at; empty: a motion begins here
  std::vector<double> singular_memory;  ///< what was seen of places where K loses rank; empty: it keeps it
  std::vector<double> rounding_memory;  ///< how well accelerations are known, see motion/rounding.hpp; empty: not asked
  std::vector<double> stiff_memory;     ///< whether explicit steps turned out stiff; empty: auto did not choose
  std::vector<double> state_before;     ///< where one may come next: of the last step's beginning; else empty
};

}  // namespace tanor
