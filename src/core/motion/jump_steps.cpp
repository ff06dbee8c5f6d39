#include "motion/jump_steps.hpp"

#include <algorithm>
#include <string>

#include "base/text.hpp"

namespace tanor::detail {

JumpSteps::Cut JumpSteps::cut_at(const PointPath::Jump& jump, bool has_stages, double h, double resolution) const {
  constexpr double most_left = 0.1;
  const double rounding = 0.25 * resolution;  // of instants
  const double left = has_stages ? std::min(jump.before, most_left) : 0.0;
  if (const double before = (1.0 - left) * jump.before * h - rounding; before > 2.0 * resolution)
    return {before, false};
  return {std::max(jump.after * h, resolution) + rounding, true};
}

JumpSteps::Cut JumpSteps::cut_again(const Cut& cut, double resolution) const {
  constexpr double shorter = 0.7, longer = 1.37, most = 1e6;
  constexpr int most_tries = 3;
  if (cut.is_over) return cut.length < most * resolution ? Cut{longer * cut.length, true} : Cut{};
  if (cut.tries == most_tries || !(cut.length > 2.0 * resolution)) return {};
  return {shorter * cut.length, false, cut.tries + 1};
}

/// A motion may pass jumps as often as it likes, and within less than it may miss. One that comes to rest at a jump
/// passes it ever sooner, in no time at last.
Outcome JumpSteps::note_jump(const PointPath::Jump& jump, double t, double resolution) {
  constexpr double no_time = 1e4, sooner = 0.5;  // resolutions; part of the time at first
  constexpr int most = 200;
  const double since = t - last_time_, none = no_time * resolution;
  const bool goes_on = since < std::max(none, jump.idle);
  count_ = goes_on ? count_ + 1 : 0;
  longest_ = goes_on ? std::max(longest_, since) : 0.0;
  last_time_ = t;
  const bool rests = since < none || since < sooner * longest_;
  return count_ < most || !rests ? Outcome{} : explain(jump, t);
}

Outcome JumpSteps::explain(const PointPath::Jump& jump, double t) {
  if (!jump.exists()) return {};
  return {Status::NotConverged, (jump.force != nullptr ? *jump.force : std::string("a force")) +
                                    " jumps without end at t = " + text(t) +
                                    ": it drives points back to where it jumps from both sides, and no motion along "
                                    "that is defined"};
}

}  // namespace tanor::detail
