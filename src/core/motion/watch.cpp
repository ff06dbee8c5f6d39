#include "motion/watch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "base/text.hpp"

namespace tanor::detail {

namespace {

/// A passage so near to the end of a step, over its time or length, is at its end, since states are rounded.
constexpr double nearly_at_end = 1e-12;

/// The sign of a function that is at 0, over that to which it goes from there.
constexpr double at_zero = 0.5;

double sign_of(double value) {
  return value > 0.0 ? 1.0 : value < 0.0 ? -1.0 : 0.0;
}

}  // namespace

void Watch::add(Function function) {
  functions_.push_back(std::move(function));
  signs_.push_back(std::numeric_limits<double>::quiet_NaN());
  samples_.emplace_back(RootIsolation::places.size());
  rounding_.push_back(0.0);
  for (std::vector<double>* array : {&x_, &v_}) array->resize(mechanics_.size());
}

void Watch::begin(double t) {
  std::fill(signs_.begin(), signs_.end(), std::numeric_limits<double>::quiet_NaN());
  std::erase_if(passages_, [t](const Passage& passage) { return passage.time > t; });
}

void Watch::note_passed(std::size_t k, bool rises) {
  signs_[k] = rises ? at_zero : -at_zero;
}

std::string Watch::name_of(std::size_t k) const {
  const std::string& name = functions_[k].name;
  return "event " + (name.empty() ? text(k) : "\"" + name + "\"");
}

/// Sets the state inside the step.
Outcome Watch::go_to(const Step& step, double fraction) {
  if (fraction == 0.0 || fraction == 1.0) {
    const State& end = fraction == 0.0 ? step.from : step.to;
    x_ = end.x;
    v_ = end.v;
  } else if (Outcome found = step.dense->evaluate(mechanics_.parallel(), fraction, x_.data(), v_.data()); !found.ok()) {
    return found;
  }
  mechanics_.prescribe(step.time(fraction), x_.data(), v_.data());
  return {};
}

/// Evaluates a function at the state inside the step. A value that is not finite is a failure, "event "vertical" is not
/// finite at t = 1.5", except where a search narrows a pole and may hit it.
double Watch::evaluate(std::size_t k, double t, Infinite infinite) {
  constexpr double large = 1e100;
  const double value = functions_[k].value(t, x_.data(), v_.data());
  if (std::isinf(value) && infinite == Infinite::IsLarge) return std::copysign(large, value);
  if (!std::isfinite(value) && failure_.ok())
    failure_ = {Status::NotFinite, name_of(k) + " is not finite at t = " + text(t)};
  return value;
}

/// Evaluates all functions at the first places.
Outcome Watch::sample(const Step& step) {
  failure_ = {};
  for (std::size_t i = 0; i < RootIsolation::places.size(); ++i) {
    const double s = RootIsolation::places[i];
    if (Outcome found = go_to(step, s); !found.ok()) return found;
    for (std::size_t k = 0; k < functions_.size(); ++k) samples_[k][i] = evaluate(k, step.time(s));
    if (!failure_.ok()) return failure_;
  }
  return {};
}

/// Measures what rounding of the state makes of the values: a function that should be 0 is the difference of large
/// ones. Each number is moved by some roundings of the largest of three, as of the coordinates of a point, and so is
/// the time.
void Watch::measure_rounding(const Step& step) {
  constexpr double roundings = 4.0 * std::numeric_limits<double>::epsilon();
  const auto shake = [](const std::vector<double>& given, std::vector<double>* to) {
    for (std::size_t i = 0; i < given.size(); ++i) {
      double size = 0.0;
      for (std::size_t j = i - i % 3; j < std::min(i - i % 3 + 3, given.size()); ++j)
        size = std::max(size, std::abs(given[j]));
      const bool is_up = (i * 2654435761U >> 13U) % 2U == 0U;
      (*to)[i] = given[i] + (is_up ? roundings : -roundings) * size;
    }
  };
  shake(step.to.x, &x_);
  shake(step.to.v, &v_);
  mechanics_.prescribe(step.to.t, x_.data(), v_.data());
  for (std::size_t k = 0; k < functions_.size(); ++k) {
    const double t = step.to.t + roundings * std::max(std::abs(step.to.t), step.h());
    const double moved = std::abs(functions_[k].value(t, x_.data(), v_.data()) - samples_[k].back());
    rounding_[k] = std::isfinite(moved) ? 4.0 * moved : 0.0;
  }
}

/// Returns the slope of the function, over the length of the step, at an end of it that may lie within rounding of a
/// zero; 0 if the end is no such.
double Watch::slope_at_zero(const Step& step, bool is_last, const RootIsolation::Function& g) const {
  const std::span<const RootIsolation::Sample> samples = isolation_.samples();
  const double value = (is_last ? samples.back() : samples.front()).value;
  double largest = 0.0;
  for (const RootIsolation::Sample& sample : samples) largest = std::max(largest, std::abs(sample.value));
  const double near = nearly_at_end * std::max(std::abs(step.to.t), step.h()) / step.h();
  const double beside = std::clamp(100.0 * near, 1e-6, 0.5);
  if (!(std::abs(value) <= beside * largest)) return 0.0;
  const double slope = is_last ? (value - g(1.0 - beside)) / beside : (g(beside) - value) / beside;
  return std::abs(value) <= near * std::abs(slope) ? slope : 0.0;
}

/// Behind a pole the function has its other sign, but it did not pass 0. Of passages within the rounding of a state,
/// as where a function jumps, one to the other side takes back the last.
void Watch::add_crossing(const Step& step, std::size_t k, double t, bool rises, bool is_pole) {
  const bool takes_back = !pending_.empty() && pending_.back().passage.event == k &&
                          pending_.back().passage.rises != rises &&
                          t - pending_.back().passage.time <= time_resolution(t, step.h());
  if (takes_back) return pending_.pop_back();
  const Event::Direction wanted = functions_[k].direction;
  const bool is_wanted = wanted == Event::Direction::Both || (wanted == Event::Direction::Rising) == rises;
  pending_.push_back({{k, t, rises}, is_wanted && !is_pole});
}

/// Follows the sign of a function through the samples, between which it changes once at most. Next to a zero at an end
/// of the step it has the sign of its slope there, or the other one, so that a second root right beside it is seen.
Outcome Watch::follow_sign(const Step& step, std::size_t k, const RootIsolation::Function& g) {
  const std::span<const RootIsolation::Sample> samples = isolation_.samples();
  const std::size_t last = samples.size() - 1;
  double sign = signs_[k];
  if (std::isnan(sign)) {
    const double slope = slope_at_zero(step, false, g);
    sign = slope != 0.0 ? at_zero * sign_of(slope) : sign_of(samples[0].value);
  }
  // At once behind a zero of higher order the interpolation may have another sign.
  const auto may_rise = [](const RootIsolation::Sample& each) { return each.s > 0.5 || each.value >= 0.0; };
  const bool is_at_start = signs_[k] == 0.0 || (std::isnan(signs_[k]) && std::abs(sign) < 1.0);
  if (functions_[k].passes_at_start && is_at_start && !(samples[0].value > 0.0) && samples[last / 2].value > 0.0 &&
      std::ranges::all_of(samples.subspan(1), may_rise)) {
    add_crossing(step, k, step.from.t, true);
    sign = at_zero;
  }
  const bool leaves_zero = std::abs(sign) < 1.0;
  sign = first_signs_[k] = sign_of(sign);
  if (leaves_zero && sign != 0.0) isolation_.leave_zero(sign, false);
  const double slope_at_end = slope_at_zero(step, true, g);
  if (slope_at_end != 0.0) isolation_.leave_zero(-sign_of(slope_at_end), true);
  for (std::size_t i = leaves_zero ? 1 : 0; i <= last; ++i) {
    const double now = sign_of(samples[i].value);
    if (now * sign < 0.0) {
      double fraction = samples[i == 0 ? 0 : i - 1].s;
      bool is_pole = false;
      if (i > 0 && samples[i - 1].value != 0.0) {
        fraction = isolation_.find_root(i - 1, g);
        is_pole = failure_.ok() && isolation_.is_pole(fraction, g);
      }
      if (!failure_.ok()) return failure_;
      add_crossing(step, k, step.time(fraction), now > 0.0, is_pole);
    }
    if (first_signs_[k] == 0.0) first_signs_[k] = now;
    if (now != 0.0) sign = now;
  }
  // A passage right behind the end counts here.
  if (slope_at_end != 0.0) add_crossing(step, k, step.to.t, slope_at_end > 0.0);
  return failure_;
}

Outcome Watch::find_crossings(const Step& step, std::size_t k) {
  const auto g = [&](double s) {
    if (Outcome found = go_to(step, s); !found.ok()) failure_ = found;
    return failure_.ok() ? evaluate(k, step.time(s), Infinite::IsLarge) : std::numeric_limits<double>::quiet_NaN();
  };
  constexpr double finest = 2.0 * std::numeric_limits<double>::epsilon();
  isolation_.isolate(samples_[k], g, {rounding_[k], finest * std::max(1.0, std::abs(step.to.t) / step.h())});
  if (!failure_.ok()) return failure_;
  if (const double s = isolation_.doubtful_place(); !std::isnan(s) && doubt_.empty())
    doubt_ = name_of(k) + " may pass 0 unseen near t = " + text(step.time(s));
  return follow_sign(step, k, g);
}

/// Returns when the first event that stops is passed.
double Watch::find_stop(const Step& step) const {
  const auto stops = [&](const Crossing& one) { return one.is_reported && functions_[one.passage.event].stops; };
  const auto first = std::find_if(pending_.begin(), pending_.end(), stops);
  if (first == pending_.end()) return std::numeric_limits<double>::infinity();
  const double finest = time_resolution(step.to.t, step.h()), t = first->passage.time;
  return t + finest >= step.to.t ? step.to.t : std::max(t, step.from.t + finest);
}

Outcome Watch::look(const State& from, State* to, DenseOutput dense, double* stop) {
  *stop = std::numeric_limits<double>::infinity();
  pending_.clear();
  doubt_.clear();
  end_ = to->t;
  first_signs_ = signs_;
  const Step step{from, *to, &dense};
  if (Outcome found = sample(step); !found.ok()) return found;
  measure_rounding(step);
  for (std::size_t k = 0; k < functions_.size(); ++k)
    if (Outcome found = find_crossings(step, k); !found.ok()) return found;
  std::stable_sort(pending_.begin(), pending_.end(),
                   [](const Crossing& a, const Crossing& b) { return a.passage.time < b.passage.time; });
  *stop = find_stop(step);
  return leave(dense, to);
}

/// Returns the mechanics to the end of the step.
Outcome Watch::leave(const DenseOutput& dense, State* to) {
  mechanics_.prescribe(to->t, to->x.data(), to->v.data());
  // Variables other than positions change what they are converted with.
  const bool has_solved = std::ranges::any_of(functions_, &Function::solves);
  if (!dense.has_moved() && mechanics_.keeps_variables() && !has_solved) return {};
  return mechanics_.accelerations(to->at(), options_.request(Gradients::Evaluate), to->output_without_power());
}

void Watch::end_at(double stop) {
  const double same = 2.0 * time_resolution(stop, end_ - stop);
  std::erase_if(pending_, [&](const Crossing& one) { return one.passage.time > stop + same; });
  for (Crossing& one : pending_)
    if (one.passage.time > stop - same) one.passage.time = stop;
  end_ = stop;
}

void Watch::accept(double t) {
  if (t != end_) return;
  signs_ = first_signs_;
  for (const Crossing& crossing : pending_) {
    const double size = crossing.passage.time >= end_ ? at_zero : 1.0;
    signs_[crossing.passage.event] = crossing.passage.rises ? size : -size;
    if (crossing.is_reported) passages_.push_back(crossing.passage);
  }
  end_ = std::numeric_limits<double>::quiet_NaN();
  if (may_be_missed_.empty()) may_be_missed_ = doubt_;
}

}  // namespace tanor::detail
