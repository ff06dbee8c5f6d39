#include "motion/jump_steps.hpp"

#include <algorithm>
#include <string>

#include "base/text.hpp"

namespace tanor {

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
  if (cut.is_over) return cut.length < most * resolution ? Cut{longer * cut.length, true} : Cut{};
  return cut.length > 2.0 * resolution ? Cut{shorter * cut.length, false} : Cut{};
}

Outcome JumpSteps::note_jump(const PointPath::Jump& jump, double t, double h) {
  constexpr double no_time = 1e-5;  // part of a step
  constexpr int most = 200;
  count_ = t - last_time_ < no_time * h ? count_ + 1 : 0;
  last_time_ = t;
  if (count_ < most) return {};
  return {Status::NotConverged, (jump.force != nullptr ? *jump.force : std::string("a force")) +
                                    " jumps without end at t = " + text(t) +
                                    ": it drives points back to where it jumps from both sides, and no motion along "
                                    "that is defined"};
}

}  // namespace tanor
