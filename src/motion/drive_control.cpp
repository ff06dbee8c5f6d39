#include "motion/drive_control.hpp"

#include <algorithm>
#include <cmath>

#include "system/text.hpp"

namespace tanor {

DriveControl::DriveControl(const MotionOptions& options, const Scheme& scheme, Mechanics& mechanics)
    : options_(options), mechanics_(mechanics), degree_(std::max(2, scheme.order())) {}

void DriveControl::begin(double t) {
  begin_ = seen_until_ = t;
  length_ = 0.0;
  pieces_ = 1.0;
}

void DriveControl::restore(double t, std::span<const double> memory) {
  begin(t);
  if (memory.empty()) return;
  if (memory.size() != 4) {
    throw InputError("/snapshot/drive_memory", "holds " + std::to_string(memory.size()) + " numbers, not 4");
  }
  begin_ = memory[0];
  seen_until_ = memory[1];
  length_ = memory[2];
  pieces_ = memory[3];
}

void DriveControl::advance(double t, double t_end) {
  constexpr double samples = 4096.0;
  spacing_ = std::max(t_end - t, t - begin_) / samples;
  end_ = t_end;
}

void DriveControl::look(const State& from, double h) {
  report_ = mechanics_.look_at_drives(
      {from.t, h, spacing_, degree_, options_.atol, options_.rtol, from.x.data(), from.v.data()});
}

/// No function acts, or a look of before reached as far.
bool DriveControl::has_seen(const State& from, double h) {
  report_ = {};
  const bool has_seen = !mechanics_.has_drives() || from.t + h <= seen_until_;
  if (has_seen) set_pieces(h);
  return has_seen;
}

void DriveControl::set_pieces(double h) {
  step_pieces_ = length_ > 0.0 ? static_cast<int>(std::ceil(pieces_ * std::min(1.0, h / length_))) : 1;
}

/// Twice as far as the last time, or half as far, …, at least h; returns how far sees() is true, 0: not even there.
template <class Sees>
double DriveControl::look_ahead(const State& from, double h, const Sees& sees) {
  double length = std::max(h, std::min(2.0 * length_, end_ - from.t));
  look(from, length);
  // Where functions depend on the state, too, a look is good for the state at hand.
  if (!report_.is_of_time_alone && length > h) look(from, length = h);
  while (!sees() && length > h) look(from, length = std::max(h, 0.5 * length));
  return sees() ? length : 0.0;
}

/// Where the error falls with its power of h it says how much shorter; where something is hidden, half of the step is
/// looked at.
double DriveControl::shorten(const State& from, double h, double shortest) {
  if (has_seen(from, h)) return h;
  double length = look_ahead(from, h, [this] { return report_.error <= 1.0; });
  while (length == 0.0 && h > shortest) {
    h *= std::clamp(0.9 * std::pow(report_.error, -1.0 / (degree_ + 2)), 0.5, 0.9);
    look(from, h);
    if (report_.error <= 1.0) length = h;
  }
  length_ = std::max(length, h);
  pieces_ = report_.pieces;
  seen_until_ = report_.is_of_time_alone ? from.t + length : from.t;
  set_pieces(h);
  return h;
}

void DriveControl::watch(const State& from, double h) {
  if (has_seen(from, h)) return;
  const double length = look_ahead(from, h, [this] { return report_.velocity == 0.0; });
  length_ = std::max(length, h);
  pieces_ = report_.pieces;
  seen_until_ = report_.is_of_time_alone ? from.t + length : from.t;
  set_pieces(h);
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
