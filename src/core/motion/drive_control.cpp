#include "motion/drive_control.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

constexpr int high_degree = 20;

/// Returns the factor that makes the error of an interval 1, if the error grows with the power degree + 2 of its
/// length.
double scale_for(double error, int degree) {
  return 0.9 * std::pow(std::max(error, 1e-30), -1.0 / (degree + 2));
}

}  // namespace

DriveControl::DriveControl(const IntegrationOptions& options, const Scheme& scheme, Mechanics& mechanics)
    : options_(options), mechanics_(mechanics), monitor_(mechanics.drives()) {
  follow(scheme);
}

void DriveControl::follow(const Scheme& scheme) {
  degree_ = std::max(2, scheme.order());
  is_fixed_ = !scheme.is_adaptive();
  seen_until_ = begin_;
}

void DriveControl::begin(double t) {
  begin_ = seen_until_ = t;
  longest_seen_ = length_ = next_length_ = 0.0;
  pieces_ = 1.0;
}

void DriveControl::advance(double t, double t_end) {
  constexpr double samples = 4096.0;
  if (t_end == end_ && spacing_ > 0.0) return;  // an advance that was stopped before its end continues
  spacing_ = std::max(t_end - t, t - begin_) / samples;
  end_ = t_end;
}

void DriveControl::look(const State& from, double h, int degree) {
  DriveReport own;
  std::array<double, 3> largest{};
  (void)mechanics_.together(
      [&] {
        own = monitor_->look_at_drives(
            {from.t, h, spacing_, degree, options_.atol, options_.rtol, from.x.data(), from.v.data()});
        largest = {own.error, own.velocity, static_cast<double>(own.pieces)};
        return Outcome{};
      },
      largest);
  report_ = {largest[0], largest[1], static_cast<int>(largest[2]), own.drive};
  is_here_ = !(own.velocity < report_.velocity);
}

/// Returns true if no function of time acts or if an earlier look covers this step.
bool DriveControl::has_seen(const State& from, double h) {
  report_ = {};
  const bool has_seen = monitor_ == nullptr || (from.t + h <= seen_until_ && h <= longest_seen_);
  if (has_seen) set_pieces(h);
  return has_seen;
}

void DriveControl::remember(const State& from, double length, double longest_step) {
  seen_until_ = from.t + length;
  longest_seen_ = longest_step;
  length_ = length;
  next_length_ = length * std::clamp(scale_for(report_.error, high_degree), 1.0, 4.0);
  pieces_ = report_.pieces;
}

void DriveControl::set_pieces(double h) {
  step_pieces_ = length_ > 0.0 ? static_cast<int>(std::ceil(pieces_ * std::min(1.0, h / length_))) : 1;
}

/// Looks as far ahead as the last look advises and halves that distance until a look serves steps of length h. Returns
/// false if none does.
bool DriveControl::look_ahead(const State& from, double h) {
  const double part = std::min(1.0, static_cast<double>(degree_) / high_degree);
  const double least = h / part, most = end_ - from.t;
  for (double length = std::min(most, std::max(least, next_length_)); length >= least; length *= 0.5) {
    look(from, length, std::max(degree_, high_degree));
    if (!sees()) continue;
    remember(from, length, part * length);
    return true;
  }
  return false;
}

/// The error tells how much shorter the step has to be if it falls with its power of h. If a function hides something
/// in the step, the next look covers half of it.
double DriveControl::shorten(const State& from, double h, double shortest) {
  if (has_seen(from, h)) return h;
  if (!look_ahead(from, h)) {
    look(from, h, degree_);
    for (; !is_fixed_ && !sees() && h > shortest; look(from, h, degree_))
      h *= std::clamp(scale_for(report_.error, degree_), 0.5, 0.9);
    remember(from, h, is_fixed_ ? 0.0 : h);
  }
  set_pieces(h);
  return h;
}

void DriveControl::note(const State& from, double h) {
  if (report_.velocity == 0.0) return;
  missed_ += report_.velocity;
  if (report_.velocity <= most_) return;
  most_ = report_.velocity;
  worst_.drive = report_.drive;
  worst_.is_here = is_here_;
  worst_.begin = from.t;
  worst_.length = h;
}

std::string DriveControl::describe() {
  const auto [begin, end] = texts_apart(std::array{worst_.begin, worst_.begin + worst_.length});
  const std::string drive = mechanics_.first_text(worst_.is_here ? monitor_->name_drive(worst_.drive) : "");
  return "steps may be too long: what " + drive + " does between t = " + begin + " and " + end + " is passed over";
}

}  // namespace tanor::detail
