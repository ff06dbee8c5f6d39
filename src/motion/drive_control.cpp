#include "motion/drive_control.hpp"

#include <algorithm>
#include <cmath>

#include "system/text.hpp"

namespace tanor {

DriveControl::DriveControl(const MotionOptions& options, const Scheme& scheme, Mechanics& mechanics)
    : options_(options), mechanics_(mechanics), degree_(std::max(2, scheme.order())) {}

void DriveControl::advance(double t, double t_end) {
  constexpr double samples = 4096.0;
  spacing_ = std::max(t_end - t, t - begin_) / samples;
}

void DriveControl::look(const State& from, double h) {
  report_ = {};
  if (!mechanics_.has_drives()) return;
  report_ = mechanics_.look_at_drives(
      {from.t, h, spacing_, degree_, options_.atol, options_.rtol, from.x.data(), from.v.data()});
}

/// Where the error falls with its power of h it says how much shorter; where something is hidden, half of the step is
/// looked at.
double DriveControl::shorten(const State& from, double h, double shortest) {
  for (look(from, h); report_.error > 1.0 && h > shortest; look(from, h))
    h *= std::clamp(0.9 * std::pow(report_.error, -1.0 / (degree_ + 2)), 0.5, 0.9);
  return h;
}

void DriveControl::note(const State& from, double h) {
  if (report_.velocity == 0.0) return;
  missed_ += report_.velocity;
  if (report_.velocity <= most_) return;
  most_ = report_.velocity;
  worst_drive_ = report_.drive;
  worst_begin_ = from.t;
  worst_length_ = h;
}

std::string DriveControl::describe() const {
  return "steps may be too long: what " + mechanics_.name_drive(worst_drive_) + " does between t = " +
         text(worst_begin_) + " and " + text(worst_begin_ + worst_length_) + " is passed over";
}

}  // namespace tanor
