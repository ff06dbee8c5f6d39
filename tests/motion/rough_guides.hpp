#pragma once

/// \file Helpers that the tests of stick and slip share: instants of events, roots, a fine reference.

#include <cmath>
#include <functional>
#include <vector>

#include <tanor/motion.hpp>

namespace tanor {

/// Advances to t_end and returns the instants at which contacts began or ceased to slide, s.
inline std::vector<double> advance_and_list_events(Simulation* simulation, double t_end) {
  std::vector<double> instants;
  std::size_t known = simulation->report().events;
  static_cast<void>(simulation->advance_to(t_end, [&](const MotionReport& report) {
    if (report.events > known) instants.push_back(report.last_event);
    known = report.events;
    return true;
  }));
  return instants;
}

/// Returns where f changes its sign between a and b, by bisection.
inline long double find_root(const std::function<long double(long double)>& f, long double a, long double b) {
  const bool rises = f(b) > 0.0L;
  for (int k = 0; k < 200; ++k) {
    const long double middle = 0.5L * (a + b);
    ((f(middle) > 0.0L) == rises ? b : a) = middle;
  }
  return 0.5L * (a + b);
}

}  // namespace tanor
