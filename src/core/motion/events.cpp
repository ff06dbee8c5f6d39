#include "motion/events.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "base/root_bracket.hpp"
#include "base/text.hpp"
#include "motion/least_of_cubic.hpp"

namespace tanor::detail {

namespace {

// All thresholds of events. A value is measured relative to the largest magnitude of its function in the step.

constexpr double rounding = 1e-13;  // A value nearer to 0 counts as 0.
/// A function below this where another one vanishes vanishes with it, and a function that starts below this starts at
/// 0.
constexpr double vanishing = 1e-10;
/// The inside of a step is sampled if its ends hint at a dip below this part of the smaller end value.
constexpr double hint = 0.5;
/// A predicted minimum below this is sampled, since shapes are parabolas in short pieces alone.
constexpr double near = 0.05;
/// A function that would be 0 so soon after the end of a step, over its time or length, is 0 there, since states are
/// rounded.
constexpr double at_end = 1e-12;
/// The dense output narrows the root to this part of the step. Secants over repeated steps do the rest.
constexpr double dense_tolerance = 1e-7;
/// A step is repeated 2 to 4 times if functions are smooth. Bisection takes over after `most_secants`, as for jumps.
constexpr int most_passes = 60, most_secants = 15;
constexpr int most_probes = 12;  // probes for a rise from 0, down to 1/8^12 of the step
constexpr int most_dips = 6;     // dips that are sampled, plus one for each piece of a step
constexpr std::size_t usual_samples = 8;
constexpr std::size_t most_switches = 50;  // switches without progress of time

bool are_positive(std::span<const double> values) {
  return std::all_of(values.begin(), values.end(), [](double f) { return f > 0.0; });
}

}  // namespace

void Events::restore(std::size_t count, double last_time, std::span<const double> slopes) {
  switches_.count = count;
  switches_.last_time = last_time;
  forget();
  slopes_.assign(slopes.begin(), slopes.end());
}

std::vector<int> Events::discrete_state() const {
  return functions_ != nullptr ? functions_->discrete_state() : std::vector<int>{};
}

void Events::restore_discrete_state(std::span<const int> state) {
  if (functions_ != nullptr) {
    functions_->restore_discrete_state(state);
    return count_functions();
  }
  if (state.empty()) return;
  throw InputError("/snapshot/discrete_state", std::to_string(state.size()) + " modes for 0 contacts that may stick");
}

void Events::forget() {
  slopes_.clear();
  without_progress_.num = 0;
  knows_start_ = false;
}

void Events::exchange_memory(Memory& memory) {
  resize();
  memory.exchange(knows_start_, start_.values, start_.shapes, start_.slopes, without_progress_.num,
                  without_progress_.begin);
}

/// Evaluates all functions, of all processes, at a state whose accelerations were found.
Outcome Events::evaluate(const Kinematics& at, const Reactions& reactions, double* values) {
  if (own_.num < num_) {
    std::fill_n(values, num_, 0.0);
    std::ranges::fill(shapes_, 0.0);
  }
  double* const own = values + own_.first;
  if (own_.num > 0) {
    functions_->evaluate_events(at, reactions, own);
    functions_->shape_events(reactions, own, shapes_.data() + own_.first);
    functions_->evaluate_slopes(at, std::span(shape_slopes_).subspan(own_.first, own_.num));
  }
  mechanics_.add({values, num_});
  mechanics_.add(shapes_);
  for (std::size_t k = 0; k < num_; ++k) {
    if (!std::isfinite(values[k])) {
      return {Status::NotFinite, "event function " + std::to_string(k) + " is not finite at t = " + text(at.t)};
    }
  }
  return {};
}

void Events::count_functions() {
  num_ = own_.num = functions_ != nullptr ? functions_->num_events() : 0;
  if (functions_ == nullptr || mechanics_.is_alone()) return;
  const Share share = mechanics_.share(own_.num);
  num_ = share.all();
  own_.first = share.first;
}

/// Makes room for as many functions as the present equations have.
void Events::resize() {
  if (mechanics_.is_alone()) count_functions();
  for (std::vector<double>* array :
       {&start_.values, &start_.shapes, &start_.slopes, &shapes_, &shape_slopes_, &scales_, &values_})
    array->resize(num_);
  samples_.resize(std::max(samples_.size(), usual_samples));
  for (Sample& sample : samples_) {
    sample.values.resize(num_);
    sample.shapes.resize(num_);
    sample.slopes.resize(num_);
  }
  is_watched_.resize(num_);
  which_.reserve(num_);
  for (std::vector<double>* array : {&inside_.x, &inside_.v, &inside_.a})
    array->resize(num_ > 0 ? mechanics_.size() : 0);
}

Outcome Events::start(const State& state) {
  if (knows_start_) return {};
  resize();
  knows_start_ = true;
  if (num_ == 0) return {};
  Outcome found = mechanics_.accelerations(state.at(), options_.request(Gradients::Evaluate), output_inside());
  if (found.ok()) found = evaluate(state.at(), inside_.reactions, start_.values.data());
  start_.shapes = shapes_;
  start_.slopes = shape_slopes_;
  return found;
}

/// Returns the mechanics to the end of a step after the inside of the step was sampled.
Outcome Events::return_to(State* state) {
  mechanics_.prescribe(state->t, state->x.data(), state->v.data());
  return mechanics_.accelerations(state->at(), options_.request(Gradients::Evaluate),
                                  {inside_.a.data(), nullptr, &state->report, &state->reactions});
}

Outcome Events::evaluate_inside(DenseOutput* dense, double fraction, double* values) {
  const double t = dense->time(fraction);
  Outcome found = dense->evaluate(mechanics_.parallel(), fraction, inside_.x.data(), inside_.v.data());
  if (!found.ok()) return found;
  mechanics_.prescribe(t, inside_.x.data(), inside_.v.data());
  const Kinematics at{t, inside_.x.data(), inside_.v.data()};
  found = mechanics_.accelerations(at, options_.request(Gradients::Evaluate), output_inside());
  if (found.ok()) found = evaluate(at, inside_.reactions, values);
  return found;
}

/// Adds a sample and keeps the samples in order.
Outcome Events::add_sample(DenseOutput* dense, double fraction) {
  if (num_samples_ == samples_.size()) {
    const std::vector<double> nothing(num_);
    samples_.push_back({0.0, nothing, nothing, nothing});
  }
  Sample& sample = samples_[num_samples_++];
  sample.fraction = fraction;
  Outcome found = evaluate_inside(dense, fraction, sample.values.data());
  sample.shapes = shapes_;
  sample.slopes = shape_slopes_;
  const auto begin = samples_.begin(), end = begin + static_cast<std::ptrdiff_t>(num_samples_);
  const auto before = [](const Sample& a, const Sample& b) { return a.fraction < b.fraction; };
  std::rotate(std::upper_bound(begin, end - 1, *(end - 1), before), end - 1, end);
  return found;
}

/// The parabola f(s) = f0 + m h s + c s^2 through both ends, with the slope m of the previous step, has its minimum f0
/// - (m h)^2/(4c). Where the slopes of both ends are known, a cubic takes its place.
bool Events::may_dip(double h) const {
  const std::vector<double>&first = samples_[0].shapes, &last = samples_[num_samples_ - 1].shapes;
  const std::vector<double>&falls = samples_[0].slopes, &rises = samples_[num_samples_ - 1].slopes;
  for (std::size_t k = 0; k < num_; ++k) {
    if (const auto least = least_of_cubic(first[k], h * falls[k], last[k], h * rises[k])) {
      if (least->value < hint * std::min(first[k], last[k])) return true;
    }
    if (falls[k] != EventFunctions::unknown_slope) continue;
    if (slopes_.size() != num_) return true;
    const double rise = slopes_[k] * h, curvature = last[k] - first[k] - rise;
    const bool has_minimum_inside = rise < 0.0 && curvature > -0.5 * rise;
    if (has_minimum_inside && first[k] - 0.25 * rise * rise / curvature < hint * std::min(first[k], last[k]))
      return true;
  }
  return false;
}

/// Fits a parabola through each inner sample of a shape and its neighbours, up to the first sample that is not
/// positive. Returns the fraction at which the lowest minimum lies, each relative to the largest magnitude of its
/// shape, or 0 if none is below `margin`.
double Events::find_dip(double margin, double h) const {
  double lowest = margin, place = 0.0;
  const std::size_t end = first_not_positive();
  for (std::size_t k = 0; k < num_; ++k) {
    double scale = std::numeric_limits<double>::min();
    for (std::size_t i = 0; i < num_samples_; ++i) scale = std::max(scale, std::abs(samples_[i].shapes[k]));
    for (std::size_t i = 1; i + 1 < end; ++i) {
      // f(s) = f + m s + c s^2, where s counts from the middle sample
      const double f = samples_[i].shapes[k];
      const double left = samples_[i - 1].fraction - samples_[i].fraction;
      const double right = samples_[i + 1].fraction - samples_[i].fraction;
      const double from_left = (samples_[i - 1].shapes[k] - f) / left;
      const double from_right = (samples_[i + 1].shapes[k] - f) / right;
      const double curvature = (from_right - from_left) / (right - left);
      const double slope = from_right - curvature * right;
      if (!(curvature > 0.0)) continue;
      const double s = -0.5 * slope / curvature, value = f + 0.5 * slope * s;
      const bool is_found = value > 0.9 * f;  // the sample is at the minimum already, and positive
      if (value / scale < lowest && !is_found && s > left && s < right && s != 0.0) {
        lowest = value / scale;
        place = samples_[i].fraction + s;
      }
    }
    for (std::size_t i = 1; i < std::min(end + 1, num_samples_); ++i) {
      const Sample &before = samples_[i - 1], &after = samples_[i];
      const double length = after.fraction - before.fraction;
      const auto least = least_of_cubic(before.shapes[k], length * h * before.slopes[k], after.shapes[k],
                                        length * h * after.slopes[k]);
      const bool is_found = least && least->value > 0.9 * std::min(before.shapes[k], after.shapes[k]);
      if (!least || is_found || !(least->value / scale < lowest)) continue;
      lowest = least->value / scale;
      place = before.fraction + least->at * length;
    }
  }
  return place;
}

/// Returns the first sample after the start that is not positive.
std::size_t Events::first_not_positive() const {
  std::size_t i = 1;
  while (i < num_samples_ && are_positive(samples_[i].values)) ++i;
  return i;
}

/// Takes samples inside the step if a function may dip there. The values at both ends are known.
Outcome Events::take_samples(DenseOutput* dense, int pieces, double h) {
  if (pieces < 2 && !may_dip(h)) return {};
  const int places = std::max(pieces, 4);
  for (int i = 1; i < places; ++i) {
    if (Outcome found = add_sample(dense, static_cast<double>(i) / places); !found.ok()) return found;
  }
  for (int dip = 0; dip < most_dips + pieces; ++dip) {
    const double fraction = find_dip(near, h);
    if (fraction == 0.0) break;
    if (Outcome found = add_sample(dense, fraction); !found.ok()) return found;
  }
  return {};
}

void Events::measure_scales() {
  for (std::size_t k = 0; k < num_; ++k) {
    double scale = 0.0;
    for (std::size_t j = 0; j < num_samples_; ++j) scale = std::max(scale, std::abs(samples_[j].values[k]));
    scales_[k] = scale > 0.0 ? scale : 1.0;
  }
}

/// Returns true if a function is 0 at the start of the step, as after a switch. Such a function counts only if it
/// falls.
bool Events::is_at_zero(std::size_t k) const {
  return samples_[0].values[k] <= vanishing * scales_[k];
}

bool Events::falls_from_zero(std::span<const double> values) const {
  for (std::size_t k = 0; k < num_; ++k) {
    if (is_at_zero(k) && values[k] <= 0.0) return true;
  }
  return false;
}

/// Returns the least of the watched values over their scales. It falls through 0 with the first of the functions.
/// Returns true if a function falls to 0 within `part` of the step behind its end, or is rounding there already.
bool Events::reaches_zero(double part) {
  const Sample &before = samples_[num_samples_ - 2], &last = samples_[num_samples_ - 1];
  bool any = false;
  for (std::size_t k = 0; k < num_; ++k) {
    const double fall = (before.values[k] - last.values[k]) / (last.fraction - before.fraction);
    is_watched_[k] = !is_at_zero(k) && last.values[k] < fall && last.values[k] <= part * fall + 2.0 * rounding;
    any = any || is_watched_[k] != 0;
  }
  return any;
}

double Events::least(std::span<const double> values) const {
  double result = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; k < num_; ++k) {
    if (is_watched_[k] != 0) result = std::min(result, values[k] / scales_[k]);
  }
  return result;
}

/// Finds the first interval at whose end a function is not positive.
Outcome Events::bracket(DenseOutput* dense, Root* root) {
  *root = Root::None;
  const double h = dense->time(1.0) - dense->time(0.0);
  const std::size_t i = first_not_positive();
  if (i == num_samples_) {
    if (reaches_zero(at_end * std::max(std::abs(dense->time(1.0)), h) / h)) *root = Root::AtEnd;
    return {};
  }

  bracket_.low = samples_[i - 1].fraction;
  bracket_.high = samples_[i].fraction;
  std::span<double> at_low = samples_[i - 1].values, at_high = samples_[i].values;
  // A function that is 0 at the start may rise before it falls. Probes look for that rise ever nearer to the start.
  for (int probe = 0; i == 1 && probe < most_probes && falls_from_zero(at_high); ++probe) {
    const double fraction = bracket_.high / 8.0;
    if (Outcome found = evaluate_inside(dense, fraction, values_.data()); !found.ok()) return found;
    if (are_positive(values_)) {
      bracket_.low = fraction;
      at_low = values_;
      break;
    }
    bracket_.high = fraction;
    std::copy(values_.begin(), values_.end(), at_high.begin());
  }
  if (bracket_.low == 0.0 && falls_from_zero(at_high)) {
    which_.clear();
    for (std::size_t k = 0; k < num_; ++k) {
      if (is_at_zero(k) && at_high[k] <= 0.0) which_.push_back(k);
    }
    *root = Root::AtStart;
    return {};
  }
  for (std::size_t k = 0; k < num_; ++k) is_watched_[k] = bracket_.low > 0.0 || !is_at_zero(k);
  bracket_.least_low = least(at_low);
  bracket_.least_high = least(at_high);
  *root = Root::Inside;
  return {};
}

/// Repeats the step from `from` and corrects its length by secants until the least function vanishes at its end. Leaves
/// the functions there in `values_`.
Outcome Events::remake(Scheme& scheme, DenseOutput* dense, const State& from, State* to, StepResult* step) {
  RootBracket inside(bracket_.low, bracket_.least_low, bracket_.high, bracket_.least_high, dense_tolerance);
  while (!inside.is_narrow()) {
    const double fraction = inside.next();
    if (Outcome found = evaluate_inside(dense, fraction, values_.data()); !found.ok()) return found;
    inside.narrow(fraction, least(values_));
  }
  const double end = to->t, whole = end - from.t, finest = time_resolution(from.t, whole);
  const double narrow = 1.5 * finest;  // instants are rounded
  double slope = inside.slope() / whole, h = inside.root() * whole;
  double low = 0.0, high = std::max(finest, bracket_.high * whole);
  double last_h = 0.0, last = 0.0;
  for (int pass = 0; pass < most_passes; ++pass) {
    to->t = from.t + std::max(h, finest);
    if (end - to->t <= finest) to->t = end;
    h = to->t - from.t;
    if (Outcome back = mechanics_.linearise(from.t, from.x.data()); !back.ok()) return back;
    *step = scheme.step(from, h, to);
    if (!step->outcome.ok()) return step->outcome;
    if (Outcome found = evaluate(to->at(), to->reactions, values_.data()); !found.ok()) return found;
    const double now = least(values_);

    if (std::abs(now) <= rounding) return {};
    if (pass > 0) {
      if (std::abs(now) <= vanishing && std::abs(now) > 0.1 * std::abs(last)) return {};
      const double secant = (now - last) / (h - last_h);
      if (secant < 0.0 && std::isfinite(secant)) slope = secant;
    }
    if (now > 0.0 && h >= high) return {};  // the steps do not reach the dip that the dense output saw
    (now > 0.0 ? low : high) = h;
    if (high - low <= narrow && now <= 0.0) return {};
    last_h = h;
    last = now;
    h -= now / slope;
    if (high - low <= narrow)
      h = high;
    else if (pass >= most_secants)
      h = 0.5 * (low + high);  // beyond a kink another function is the least, and secants do not move one end
    else if (!(h > low && h < high) || (std::abs(h - last_h) < 0.5 * finest && std::abs(now) > vanishing))
      h = 0.5 * (low + high);  // the secant stalls at a jump of a function
  }
  return {Status::NotConverged, "the instant of an event near t = " + text(to->t) + " is not found"};
}

/// Collects the functions that vanish together with the least one.
void Events::choose_vanishing(std::span<const double> values) {
  which_.clear();
  const double bound = std::max(vanishing, least(values));
  for (std::size_t k = 0; k < num_; ++k) {
    if (is_watched_[k] != 0 && values[k] / scales_[k] <= bound) which_.push_back(k);
  }
}

/// Switches the equations of this process if its functions vanish. A process whose equations stay the same finds its
/// accelerations.
Outcome Events::switch_own(State* to) {
  own_.which.clear();
  for (const std::size_t k : which_)
    if (k >= own_.first && k < own_.first + own_.num) own_.which.push_back(k - own_.first);
  const Request request = options_.request(Gradients::Keep);
  return mechanics_.solve_together(to->output(), [&] {
    return own_.which.empty()
               ? mechanics_.accelerations(to->at(), request.evaluated_anew(), to->output())
               : functions_->switch_equations(to->t, to->x.data(), to->v.data(), own_.which, request, to->output());
  });
}

/// Leaves the equations as they were if the switch fails.
Outcome Events::switch_equations(Scheme& scheme, const State& from, State* to) {
  const double h = to->t - from.t;
  const std::vector<int> before = functions_->discrete_state();
  Outcome found = switch_own(to);
  count_functions();
  if (found.ok()) {
    resize();
    found = evaluate(to->at(), to->reactions, start_.values.data());
    start_.shapes = shapes_;
    start_.slopes = shape_slopes_;
  }
  if (without_progress_.num == 0 ||
      to->t - without_progress_.begin > static_cast<double>(most_switches) * time_resolution(to->t, h)) {
    without_progress_.begin = to->t;
    without_progress_.num = 0;
  }
  if (found.ok() && ++without_progress_.num > most_switches) {
    found = {Status::NotConverged, "equations switch without end at t = " + text(to->t)};
  }
  if (!found.ok()) {
    restore_discrete_state(before);
    without_progress_.num = 0;
    knows_start_ = false;
    return found;
  }
  scheme.forget();
  to->work.add(1.0, mechanics_.sum(own_.which.empty() ? Power{} : functions_->work_of_switch()));
  slopes_.clear();
  ++switches_.count;
  switches_.last_time = to->t;
  switches_.last_change = functions_->describe_change(before);
  note_changes();
  return {};
}

void Events::note_changes() {
  if (functions_ == nullptr) return;
  const std::span<const ContactEvent> changes = functions_->changes_of_switch();
  switches_.changes.insert(switches_.changes.end(), changes.begin(), changes.end());
}

void Events::take_changes(std::vector<ContactEvent>* list) {
  list->insert(list->end(), switches_.changes.begin(), switches_.changes.end());
  switches_.changes.clear();
}

Events::Meeting Events::meet(Scheme& scheme, const State& from, int pieces, State* to, StepResult* step) {
  if (num_ == 0) return {};
  DenseOutput dense(scheme, from, *to);
  num_samples_ = 2;
  samples_[0] = start_;
  samples_[1].fraction = 1.0;
  Meeting meeting;
  Outcome& found = meeting.outcome;
  if (found = evaluate(to->at(), to->reactions, samples_[1].values.data()); !found.ok()) return meeting;
  samples_[1].shapes = shapes_;
  samples_[1].slopes = shape_slopes_;
  if (found = take_samples(&dense, pieces, to->t - from.t); !found.ok()) return meeting;
  measure_scales();
  const bool looked_inside = num_samples_ > 2;
  Root root = Root::None;
  if (found = bracket(&dense, &root); !found.ok()) return meeting;

  if (root == Root::Inside) {
    if (found = remake(scheme, &dense, from, to, step); !found.ok()) return meeting;
    if (least(values_) > vanishing) root = Root::None;
    choose_vanishing(values_);
  } else if (root == Root::AtStart) {
    *to = from;
    if (found = return_to(to); !found.ok()) return meeting;
  } else {
    values_ = samples_[num_samples_ - 1].values;
    shapes_ = samples_[num_samples_ - 1].shapes;
    shape_slopes_ = samples_[num_samples_ - 1].slopes;
    if (looked_inside) found = return_to(to);
    if (!found.ok()) return meeting;
    if (root == Root::AtEnd) choose_vanishing(values_);
  }
  const double h = to->t - from.t;
  if (root == Root::None) {
    slopes_.resize(num_);
    for (std::size_t k = 0; k < num_; ++k) slopes_[k] = (shapes_[k] - start_.shapes[k]) / h;
    std::swap(start_.values, values_);
    start_.shapes = shapes_;
    start_.slopes = shape_slopes_;
  } else {
    meeting.asks_for_switch = true;
  }
  return meeting;
}

}  // namespace tanor::detail
