#include "motion/corners.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "motion/dense_output.hpp"

namespace tanor::detail {

namespace {

/// A step ends before a corner by this part of the way to it.
constexpr double margin = 1e-3;
/// The parabola is exact to rounding over this part of a step.
constexpr double nearest = 1e-7;
constexpr std::size_t samples_on_path = 8;
constexpr std::size_t most_crossings = 1000;  // in the time of one step

/// Returns true if a term has its other branch. An argument that is NaN belongs to both.
bool is_on_other_side(double one, double other) {
  return (one < 0.0 && other >= 0.0) || (one >= 0.0 && other < 0.0);
}

/// Returns the time in which a corner is right ahead. Implicit schemes divide rounding of positions by the length of a
/// step, so that none is made which is much shorter than the resolution of time allows.
double right_ahead(double t, double h) {
  constexpr double in_rounding = 1e3, in_steps = 1e-3;
  const double resolution = time_resolution(t, h);
  return std::max({nearest * h, 4.0 * resolution, std::min(in_rounding * resolution, in_steps * h)});
}

}  // namespace

Corners::Corners(const IntegrationOptions& options, Mechanics& mechanics)
    : options_(options), mechanics_(mechanics), functions_(mechanics.corners()) {
  if (empty()) return;
  for (std::vector<double>* array : {&x_, &v_}) array->resize(mechanics.size());
  for (std::vector<double>* array : {&start_, &here_, &other_, &tolerances_}) array->resize(functions_->num_terms());
}

bool Corners::differ(const std::vector<double>& one, const std::vector<double>& other) const {
  for (std::size_t k = 0; k < one.size(); ++k) {
    if (is_on_other_side(one[k], other[k])) return true;
  }
  return false;
}

/// x(s) = x + s v + s^2/2 a
void Corners::go_along(const State& from, const Place& place) {
  const double s = place.s;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    x_[i] = from.x[i] + s * (from.v[i] + 0.5 * s * from.a[i]);
    v_[i] = from.v[i] + s * from.a[i];
  }
  if (s != 0.0) mechanics_.prescribe(place.t, x_.data(), v_.data());
}

void Corners::evaluate_along(const State& from, const Place& place, std::vector<double>* arguments) {
  go_along(from, place);
  functions_->evaluate_terms({place.t, x_.data(), v_.data()}, arguments->data());
}

/// Halves the way between two places on different branches until no number lies between them.
Corners::Corner Corners::narrow(const State& from, Place low, Place high) {
  for (double s = 0.5 * (low.s + high.s); low.s < s && s < high.s; s = 0.5 * (low.s + high.s)) {
    const Place middle{s, from.t + s};
    evaluate_along(from, middle, &here_);
    (differ(start_, here_) ? high : low) = middle;
    if (high.s <= std::numeric_limits<double>::min()) break;
  }
  return {true, low, high, no_term};
}

/// Samples the path, and then ever shorter beginnings of it where an argument may pass 0 and come back before the first
/// sample.
Corners::Corner Corners::find_on_path(const State& from, double h) {
  if (!follow_motion()) return {};
  constexpr double part = 0.25;
  evaluate_along(from, {0.0, from.t}, &start_);
  measure_tolerance(from);
  samples_.resize(samples_on_path + 1, start_);
  samples_[0] = start_;
  for (double length = h; length > time_resolution(from.t, 0.0); length *= part) {
    Place low{0.0, from.t};
    for (std::size_t i = 1; i <= samples_on_path; ++i) {
      const double s = length * static_cast<double>(i) / samples_on_path;
      const Place high{s, from.t + s};
      evaluate_along(from, high, &samples_[i]);
      if (differ(start_, samples_[i])) return check_speed(from, length, narrow(from, low, high));
      low = high;
    }
    if (const Corner touch = find_touch(from, length); touch.is_found) return touch;
    if (!may_hide()) break;
  }
  return {};
}

/// Returns true if an argument changes so much up to the first sample that it may have been 0 before.
bool Corners::may_hide() const {
  constexpr double little = 0.1;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const double size = std::abs(samples_[0][k]);
    if (size > 0.0 && !(std::abs(samples_[1][k] - samples_[0][k]) <= little * size)) return true;
  }
  return false;
}

/// Measures what the tolerance of places makes of the arguments.
void Corners::measure_tolerance(const State& from) {
  const double tolerance = options_.atol > 0.0 ? options_.atol : options_.rtol;
  go_along(from, {0.0, from.t});
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] += (i % 2 == 0 ? 1.0 : 0.75) * tolerance;
  functions_->evaluate_terms({from.t, x_.data(), v_.data()}, here_.data());
  for (std::size_t k = 0; k < start_.size(); ++k) tolerances_[k] = std::abs(here_[k] - start_[k]);
}

/// A corner across which the argument turns back within its tolerance is one that the motion only touches. Along the
/// parabola u = c s + q s^2/2 it turns at c^2/(2 |q|).
Corners::Corner Corners::check_speed(const State& from, double length, Corner corner) {
  constexpr double little = 1e-3;
  const double s = corner.before.s, step = little * length;
  evaluate_along(from, corner.before, &here_);
  const std::vector<double> at = here_;
  evaluate_along(from, corner.after, &other_);
  std::vector<double> ahead(at.size());
  evaluate_along(from, {s + step, from.t + s + step}, &ahead);
  evaluate_along(from, {s - step, from.t + s - step}, &here_);
  for (std::size_t k = 0; k < at.size(); ++k) {
    if (!is_on_other_side(at[k], other_[k])) continue;
    const double c = (ahead[k] - here_[k]) / (2.0 * step), q = (ahead[k] - 2.0 * at[k] + here_[k]) / (step * step);
    if (c * q < 0.0 && c * c <= 2.0 * std::abs(q) * tolerances_[k]) return {true, corner.before, corner.before, k};
  }
  return corner;
}

/// Finds where the argument of a term turns back at 0, from the samples of a way of that length. The minimum of its
/// magnitude is narrowed by thirds.
Corners::Corner Corners::find_touch(const State& from, double length) {
  constexpr double touches = 1e-3, finest = 1e-9;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const auto size = [&](std::size_t i) { return std::abs(samples_[i][k]); };
    const auto size_at = [&](double s) {
      evaluate_along(from, {s, from.t + s}, &here_);
      return std::abs(here_[k]);
    };
    for (std::size_t i = 1; i < samples_on_path; ++i) {
      if (!(size(i) < size(i - 1) && size(i) <= size(i + 1))) continue;
      if (size(i) > std::max(0.1 * size(0), tolerances_[k])) continue;
      const double piece = length / samples_on_path;
      double low = piece * static_cast<double>(i - 1), high = low + 2.0 * piece;
      while (high - low > finest * length) {
        const double third = (high - low) / 3.0;
        size_at(low + third) < size_at(high - third) ? high -= third : low += third;
      }
      const double s = 0.5 * (low + high);
      if (size_at(s) <= std::max(touches * size(0), tolerances_[k])) return {true, {s, from.t + s}, {s, from.t + s}, k};
    }
  }
  return {};
}

/// Finds the first corner on the parabola, of a formula or of a function of time alone.
Corners::Corner Corners::find(const State& from, double h) {
  Corner found = find_on_path(from, h);
  instants_.clear();
  functions_->append_instants(from.t, from.t + h, &instants_);
  for (const double t : instants_) {
    const double next = std::nextafter(t, std::numeric_limits<double>::infinity());
    if (found.is_found && found.before.t < t) continue;
    found = {true, {t - from.t, t}, {next - from.t, next}, no_term};
  }
  go_back(from);
  return found;
}

/// Finds a corner of a formula that the end of the step may meet by rounding.
Corners::Corner Corners::find_behind(const State& from, double h) {
  const Corner found = find_on_path(from, h + right_ahead(from.t, h));
  go_back(from);
  return found;
}

void Corners::go_back(const State& from) {
  go_along(from, {0.0, from.t});
  mechanics_.prescribe(from.t, x_.data(), v_.data());
}

/// Returns the time in which arguments would reach a corner at their present rates, s, if that is shorter than the time
/// in which they do: stages of a step over a slowing motion go that far.
double Corners::reach_by_rate(const State& from, const Corner& corner) {
  constexpr double little = 1e-3;
  const double whole = corner.before.s, step = little * whole;
  std::vector<double> after(start_.size());
  evaluate_along(from, corner.after, &after);
  evaluate_along(from, {step, from.t + step}, &here_);
  go_back(from);
  double reach = whole;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    const double falls = (start_[k] - here_[k]) / start_[k];
    const bool is_met = k == corner.touched || is_on_other_side(start_[k], after[k]);
    if (is_met && falls > 0.0) reach = std::min(reach, step / falls);
  }
  return reach;
}

/// A corner right behind the end of the step may be met there by rounding.
Outcome Corners::shorten(const State& from, double h, double* clear) {
  const double reach = right_ahead(from.t, h), rounding = 4.0 * time_resolution(from.t, h);
  Corner corner = find(from, h);
  const bool is_behind = !corner.is_found;
  if (is_behind) corner = find_behind(from, h);
  *clear = h;
  for (std::size_t k = 0; k < start_.size(); ++k) {
    if (start_[k] != 0.0) continue;
    if (Outcome stands = functions_->check_standing(from.at(), k); !stands.ok()) return stands;
    if (Outcome back = mechanics_.linearise(from.t, from.x.data()); !back.ok()) return back;
  }
  is_ahead_ = corner.is_found;
  if (!corner.is_found) return {};
  // Where an argument only touches 0, singular accelerations keep steps in proportion to the way that is left, and
  // `find_touch` resolves a billionth of a long step. What is left within some tolerances tells nothing more.
  constexpr double some = 10.0;
  const std::size_t k = corner.touched;
  const double touching = k == no_term                                   ? 0.0
                          : std::abs(start_[k]) <= some * tolerances_[k] ? corner.before.s
                                                                         : 1e8 * time_resolution(from.t, h);
  if (corner.before.s <= std::max(touching, is_behind ? rounding : reach))
    *clear = 0.0;
  else
    *clear = std::min(h, (1.0 - margin) * reach_by_rate(from, corner));
  return {};
}

bool Corners::have_passed(Scheme& scheme, const State& from, const State& to) {
  if (!follow_motion()) return false;
  functions_->evaluate_terms(from.at(), start_.data());
  DenseOutput inside(scheme, from, to, true);
  for (const double fraction : {0.25, 0.5, 0.75}) {
    (void)inside.evaluate(mechanics_.parallel(), fraction, x_.data(), v_.data());  // by the ends, which cannot fail
    functions_->evaluate_terms({inside.time(fraction), x_.data(), v_.data()}, here_.data());
    if (differ(start_, here_)) return true;
  }
  functions_->evaluate_terms(to.at(), here_.data());
  return differ(start_, here_);
}

/// Refuses a motion that comes back to corners without end, as where it comes to rest in one.
Outcome Corners::check_progress(double t, double h) {
  if (!(t - series_begin_ <= h)) {
    series_begin_ = t;
    repeated_ = 0;
  }
  if (++repeated_ <= most_crossings) return {};
  repeated_ = 0;
  return {Status::NotConverged,
          "the motion comes back to the corner of " + name_passed() + " without end at t = " + text(t)};
}

/// Crosses between two places, and projects what is found onto the constraints of the other side.
StepResult Corners::cross_at(const State& from, const Corner& corner, double t_end, State* to) {
  StepResult step;
  step.is_interpolated = false;
  evaluate_along(from, corner.before, &start_);
  const std::vector<double> x = x_, v = v_;
  evaluate_along(from, corner.after, &other_);
  std::vector<std::size_t> which;
  for (std::size_t k = 0; k < start_.size(); ++k)
    if (is_on_other_side(start_[k], other_[k])) which.push_back(k);
  Power work;
  *to = from;
  const bool is_at_end = t_end - corner.after.t <= 4.0 * time_resolution(from.t, t_end - from.t);
  to->t = is_at_end ? t_end : corner.after.t;  // no step of rounding is left over
  put_on_guides(corner);
  step.outcome = functions_->cross({corner.before.t, x.data(), v.data()}, {corner.after.t, x_.data(), v_.data()}, which,
                                   to->v.data(), &work);
  if (!step.outcome.ok()) return step;
  to->work.add(1.0, work);
  // Half of the way lies beyond the corner. Straight on, no place of the other side may be near.
  const double half = 0.5 * (corner.after.s - corner.before.s);
  for (std::size_t i = 0; i < x.size(); ++i) to->x[i] = x[i] + half * (v[i] + to->v[i]);
  x_ = to->x;
  v_ = to->v;
  step = stabilize(mechanics_, options_, to, MovedVelocity::IsNoError);
  step.is_interpolated = false;
  // A projection that stalls, or leads elsewhere, is tried again farther from the corner.
  if (step.outcome.status == Status::NotConverged || (step.outcome.ok() && have_moved(*to, half)))
    step.error = std::numeric_limits<double>::infinity();
  if (!(step.error <= 1.0)) step.outcome = {};
  return step;
}

/// Moves the place beyond the corner onto the guides, whose gradients may be others beside them, as of z/|x| = 1. It
/// stays where it is if that leads back across the corner, or far away.
void Corners::put_on_guides(const Corner& corner) {
  constexpr double far = 8.0;  // times the way from one side to the other
  const std::vector<double> straight = x_;
  double fastest = 0.0, moved = 0.0;
  const ProjectionReport found = mechanics_.project_positions(corner.after.t, x_.data(), Turn::Small);
  for (std::size_t i = 0; i < x_.size(); ++i) {
    fastest = std::max(fastest, std::abs(v_[i]));
    moved = std::max(moved, std::abs(x_[i] - straight[i]));
  }
  functions_->evaluate_terms({corner.after.t, x_.data(), v_.data()}, here_.data());
  const bool is_near = moved <= far * (corner.after.s - corner.before.s) * fastest;
  if (!found.outcome.ok() || !is_near || differ(other_, here_)) x_ = straight;
}

/// Returns true if the projection has moved the state from where it was put so far that it is another one.
bool Corners::have_moved(const State& to, double travelled) const {
  constexpr double visible = 1e-6, roundings = 1e3 * std::numeric_limits<double>::epsilon();
  double fastest = 0.0, farthest = 0.0, moved_v = 0.0, moved_x = 0.0;
  for (std::size_t i = 0; i < x_.size(); ++i) {
    fastest = std::max(fastest, std::abs(v_[i]));
    farthest = std::max(farthest, std::abs(x_[i]));
    moved_v = std::max(moved_v, std::abs(to.v[i] - v_[i]));
    moved_x = std::max(moved_x, std::abs(to.x[i] - x_[i]));
  }
  const double tolerance = options_.atol > 0.0 ? options_.atol : options_.rtol;
  return !(moved_v <= visible * fastest && moved_x <= travelled * fastest + roundings * farthest + tolerance);
}

/// Names a term that has different branches on the two sides.
std::string Corners::name_passed() const {
  std::string name = "a function of time";
  for (std::size_t k = 0; k < start_.size(); ++k)
    if (is_on_other_side(start_[k], other_[k])) name = functions_->name_term(k);
  return name;
}

Outcome Corners::refuse(const Corner& corner, const std::string& why) const {
  return {Status::Singular, "the corner of " + name_passed() + " at t = " + text(corner.before.t) + ": " + why};
}

/// Refuses a corner beside which rounding decides on the gradients, as of z/|x| = 1: farther away, the motion goes on
/// with another velocity.
Outcome Corners::check_settled(const State& from, const Corner& corner, double t_end, const State& to) {
  constexpr double farther = 1e6, visible = 1e-3;  // resolutions; of the speed
  const double away = farther * time_resolution(to.t, t_end - from.t);
  const double low = corner.before.s - away, high = corner.after.s + away;
  State other;
  const Corner wide{true, {low, from.t + low}, {high, from.t + high}, no_term};
  const StepResult found = cross_at(from, wide, t_end, &other);
  if (!found.outcome.ok() || !(found.error <= 1.0)) return {};
  double fastest = 0.0, differs = 0.0;
  for (std::size_t i = 0; i < to.v.size(); ++i) {
    fastest = std::max(fastest, std::abs(to.v[i]));
    differs = std::max(differs, std::abs(to.v[i] - other.v[i]));
  }
  return differs <= visible * fastest ? Outcome{} : refuse(corner, "beside it rounding decides on the gradient");
}

/// Refuses a corner towards which accelerations grow without bound, as on z = |x|^1.5. No step from there is short
/// enough.
Outcome Corners::check_bend(const Corner& corner, double h, State* to) {
  constexpr double farther = 1e6, grows = 8.0;  // resolutions; of accelerations
  constexpr double roundings = 1e3 * std::numeric_limits<double>::epsilon();
  const double s = farther * time_resolution(to->t, h);
  std::vector<double> a(to->a.size());
  for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = to->x[i] + s * to->v[i];
  v_ = to->v;
  mechanics_.prescribe(to->t + s, x_.data(), v_.data());
  Outcome found = mechanics_.linearise(to->t + s, x_.data());
  if (found.ok()) found = mechanics_.accelerations({to->t + s, x_.data(), v_.data()}, {}, a.data());
  mechanics_.prescribe(to->t, to->x.data(), to->v.data());
  if (Outcome back = mechanics_.linearise(to->t, to->x.data()); !back.ok()) return back;
  if (Outcome back = mechanics_.accelerations(to->at(), options_.request(Gradients::Keep), to->output()); !back.ok())
    return back;
  double fastest = 0.0, near = 0.0, far = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    fastest = std::max(fastest, std::abs(to->v[i]));
    near = std::max(near, std::abs(to->a[i]));
    far = std::max(far, std::abs(a[i]));
  }
  const double noise = roundings * fastest / (corner.after.s - corner.before.s);
  if (!found.ok() || !(near > grows * far + noise)) return {};
  return refuse(corner, "accelerations grow without bound towards it");
}

/// Goes to the end of the step where the corner is met there, and not crossed yet.
StepResult Corners::arrive(const State& from, const Corner& corner, double t_end, State* to) {
  go_along(from, corner.before);
  *to = from;
  to->t = t_end;
  to->x = x_;
  to->v = v_;
  StepResult step = stabilize(mechanics_, options_, to, MovedVelocity::IsNoError);
  step.is_interpolated = false;
  return step;
}

/// Takes both places so far from the corner of a term that rounding does not tell which of several is met first.
void Corners::widen(const State& from, double h, Corner* corner) {
  const double away = 4.0 * time_resolution(from.t, h);
  evaluate_along(from, corner->before, &start_);
  evaluate_along(from, corner->after, &other_);
  if (!differ(start_, other_)) return;
  if (corner->before.s > away) corner->before = {corner->before.s - away, from.t + (corner->before.s - away)};
  corner->after = {corner->after.s + away, from.t + (corner->after.s + away)};
}

StepResult Corners::cross(const State& from, double t_end, State* to) {
  constexpr int most_tries = 12, most_failures = 3;
  const double h = t_end - from.t;
  Corner corner = find(from, h);
  if (!corner.is_found) corner = find_behind(from, h);
  if (corner.touched != no_term)
    return {.outcome = {Status::Singular, "the corner of " + functions_->name_term(corner.touched) +
                                              " at t = " + text(corner.before.t) +
                                              " is touched without speed across it, as a cusp"}};
  widen(from, h, &corner);
  if (Outcome goes_on = check_progress(corner.after.t, h); !goes_on.ok()) return {.outcome = goes_on};
  // Projections may bring a state that is only just beyond the corner back to this side of it, and exactly at it
  // derivatives may be missing.
  StepResult first;
  const double nearest_s = 0.5 * (corner.before.s + corner.after.s);
  double beyond = 0.5 * (corner.after.s - corner.before.s);
  for (int k = 0; k < most_tries; ++k, beyond *= 8.0) {
    if (k > 0) corner.after = {nearest_s + beyond, from.t + (nearest_s + beyond)};
    if (k > 0 && nearest_s > beyond) corner.before = {nearest_s - beyond, from.t + (nearest_s - beyond)};
    StepResult step = cross_at(from, corner, t_end, to);
    if (first.outcome.ok()) first = step;
    if (!step.outcome.ok() && k + 1 < most_failures) continue;
    if (!step.outcome.ok()) return first;
    if (!(step.error <= 1.0)) continue;
    functions_->evaluate_terms(to->at(), here_.data());
    if (differ(here_, other_)) continue;
    if (!follow_motion()) return step;
    const Outcome settled = check_settled(from, corner, t_end, *to);
    step.outcome = check_bend(corner, h, to);
    if (!settled.ok()) step.outcome = settled;
    return step;
  }
  if (corner.after.t > t_end) return arrive(from, corner, t_end, to);
  return {.outcome = refuse(corner, "no state beyond it is found")};
}

/// The argument of a term that falls or rises to 0 in that time, as it now does, counts as well. Roots lose half of
/// their digits before they are 0, so that a longer time is looked at where nothing is so near.
std::string Corners::name_next(const State& from, double within) {
  if (empty()) return {};
  constexpr double little = 1e-2, longer = 1e3;
  for (const double time : {within, longer * within}) {
    if (!follow_motion()) break;
    evaluate_along(from, {0.0, from.t}, &start_);
    evaluate_along(from, {little * time, from.t + little * time}, &here_);
    mechanics_.prescribe(from.t, x_.data(), v_.data());
    for (std::size_t k = 0; k < start_.size(); ++k)
      if (std::abs(start_[k]) * little <= std::abs(here_[k] - start_[k])) return functions_->name_term(k);
  }
  instants_.clear();
  functions_->append_instants(from.t, from.t + within, &instants_);
  return instants_.empty() ? "" : "a function of time";
}

}  // namespace tanor::detail
