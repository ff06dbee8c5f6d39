#include "motion/singular_places.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <type_traits>

#include "base/check.hpp"
#include "base/text.hpp"

namespace tanor {

void SingularPlaces::begin(double t) {
  forget();
  if (monitor_ != nullptr) regular_ = 1.0 / monitor_->mass_ratio();
  report_.reciprocal_condition = mechanics_.last_solve().reciprocal_condition;
  report_.reciprocal_condition_time = t;
  report_.rank_changes.start = report_.rank_changes.now = mechanics_.rank();
  note_place(t);
}

void SingularPlaces::resume() {
  if (!std::isnan(memory_.remembered)) monitor_->remember_gradients();
}

/// visit(number) for all that the next steps depend on.
template <class M, class Visit>
void SingularPlaces::for_each_number(M& memory, const Visit& visit) {
  memory.forecast.for_each_number(visit);
  visit(memory.is_coasting);
  visit(memory.is_at_one);
  visit(memory.is_in_the_way);
  visit(memory.is_foreseen);
  visit(memory.pays_to_approach);
  visit(memory.approaches);
  visit(memory.coasting_error);
  visit(memory.last_passage);
  visit(memory.remembered);
}

void SingularPlaces::write(std::vector<double>* numbers) const {
  numbers->clear();
  if (monitor_ == nullptr) return;
  numbers->push_back(regular_);
  for_each_number(memory_, [&](const auto& number) { numbers->push_back(static_cast<double>(number)); });
}

void SingularPlaces::restore(std::span<const double> numbers) {
  std::size_t count = monitor_ != nullptr ? 1 : 0;
  if (count > 0) for_each_number(memory_, [&](const auto&) { ++count; });
  if (numbers.size() != count) {
    throw InputError("/snapshot/singular_memory",
                     "holds " + std::to_string(numbers.size()) + " numbers, not " + std::to_string(count));
  }
  forget();
  if (numbers.empty()) return;
  regular_ = numbers[0];
  std::size_t next = 1;
  for_each_number(
      memory_, [&](auto& number) { number = static_cast<std::remove_reference_t<decltype(number)>>(numbers[next++]); });
}

void SingularPlaces::note(Scheme& scheme, const State& from, const State& to, const StepResult& step) {
  memory_.is_coasting = !step.is_settled;
  if (!step.is_settled) return;
  if (!std::isnan(memory_.remembered) && to.t > from.t) {
    const double ratio = monitor_->compare_gradients();
    if (ratio < 0.0)
      find_passages(scheme, from, to, step.is_interpolated);
    else if (memory_.is_foreseen && ratio > 0.0 && ratio != 1.0)
      withdraw_passage();
  }
  memory_.is_foreseen = false;
  note_place(to.t);
}

/// Where the mechanics stands.
void SingularPlaces::note_place(double t) {
  const double reciprocal_condition = mechanics_.last_solve().reciprocal_condition;
  if (reciprocal_condition < report_.reciprocal_condition) {
    report_.reciprocal_condition = reciprocal_condition;
    report_.reciprocal_condition_time = t;
  }
  if (monitor_ == nullptr) return;
  if (mechanics_.rank() != report_.rank_changes.now) memory_.forecast.forget();
  regular_ = std::max(regular_, reciprocal_condition);
  memory_.forecast.add(t, reciprocal_condition, regular_);
  const bool lies_ahead = memory_.forecast.time() > t && std::isfinite(memory_.forecast.time());
  memory_.is_in_the_way = lies_ahead && (memory_.is_in_the_way || memory_.approaches > 0);
  if (!lies_ahead) forget_approaches();
  if (is_at_one()) {
    SingularPassages& passages = report_.singular_passages;
    const bool is_last_kept = !passages.first.empty() && passages.first.size() == passages.count;
    if (!memory_.is_at_one)
      note_passage(t, reciprocal_condition);
    else if (is_last_kept && reciprocal_condition < passages.first.back().reciprocal_condition)
      passages.first.back() = {t, reciprocal_condition};
    memory_.last_passage = t;
  }
  memory_.is_at_one = is_at_one();
  if (follows_)
    remember(t);
  else
    memory_.remembered = std::numeric_limits<double>::quiet_NaN();
  note_rank(t);
}

void SingularPlaces::remember(double t) {
  monitor_->remember_gradients();
  memory_.remembered = t;
}

/// Of the last step, whose ends tell that there is one: K may have turned so far in it that they say no more. A step
/// that began while it coasted had such a place right before it, too.
void SingularPlaces::find_passages(Scheme& scheme, const State& from, const State& to, bool is_interpolated) {
  // Of a short step, near such a place all the time, the whole is little enough.
  constexpr double near = 1e-2;
  const double largest =
      std::max(memory_.forecast.reciprocal_condition(), mechanics_.last_solve().reciprocal_condition);
  const int pieces = largest < near * regular_ ? 1 : 8;
  DenseOutput dense(scheme, from, to, !is_interpolated);
  const double begin = memory_.remembered < from.t ? -0.5 : 0.0;
  Outcome found;
  if (begin < 0.0 && (found = go_inside(&dense, begin)).ok()) monitor_->remember_gradients();
  double low = begin;
  for (int k = 1; k <= pieces && found.ok(); ++k) {
    if (k > 1) monitor_->remember_gradients();
    // No symmetry of a motion leads to such a fraction.
    const double high = k < pieces ? begin + (k - 0.1371) * (1.0 - begin) / pieces : 1.0;
    if (found = go_inside(&dense, high); !found.ok()) break;
    if (const double value = monitor_->compare_gradients(); value < 0.0) {
      note_found(dense.time(narrow(&dense, low, high, value)), to.t - from.t);
      found = go_inside(&dense, high);
    }
    low = high;
  }
  x_ = to.x;
  v_ = to.v;
  mechanics_.prescribe(to.t, x_.data(), v_.data());
  found = mechanics_.accelerations({to.t, x_.data(), v_.data()}, options_.request(Gradients::Evaluate), a_.data());
  ensure(found.ok(), "where a step has ended there are accelerations");
}

Outcome SingularPlaces::go_inside(DenseOutput* dense, double fraction) {
  for (std::vector<double>* array : {&x_, &v_, &a_}) array->resize(mechanics_.size());
  if (Outcome found = dense->evaluate(mechanics_.parallel(), fraction, x_.data(), v_.data()); !found.ok()) return found;
  mechanics_.prescribe(dense->time(fraction), x_.data(), v_.data());
  return mechanics_.linearise(dense->time(fraction), x_.data());
}

/// The fraction at which a singular value of K vanishes that has other signs at both ends; K at the low one is
/// remembered. By inverse interpolation (Neville) from places on both sides that come nearer, but never so near that
/// rows would count as dependent.
double SingularPlaces::narrow(DenseOutput* dense, double low, double high, double value_high) {
  std::array<double, 6> fractions{low, high}, values{1.0, value_high};
  std::size_t count = 2;
  const auto interpolate = [&] {
    std::array<double, 6> at = fractions;
    for (std::size_t k = 1; k < count; ++k) {
      for (std::size_t i = 0; i + k < count; ++i)
        at[i] = (values[i + k] * at[i] - values[i] * at[i + 1]) / (values[i + k] - values[i]);
    }
    return std::isfinite(at[0]) ? std::clamp(at[0], low, high) : 0.5 * (low + high);  // of equal values nothing follows
  };
  constexpr double least = 1e-8;  // over a regular S
  const double at_high = mechanics_.last_solve().reciprocal_condition;
  for (const double distance : {0.05, 1e-3}) {
    const double root = interpolate(), part = distance * (high - low) / (high - root);
    if (at_high * part * part < least * regular_) return root;
    for (const double side : {-1.0, 1.0}) {
      const double fraction = root + side * distance * (high - low);
      if (!go_inside(dense, fraction).ok()) return root;
      fractions[count] = fraction;
      values[count] = monitor_->compare_gradients();
      ++count;
    }
  }
  return interpolate();
}

/// At t, in a step of length h: a new one, or the one that was foreseen there, or seen at a step's end.
void SingularPlaces::note_found(double t, double h) {
  SingularPassages& passages = report_.singular_passages;
  const double near = (memory_.is_foreseen ? 0.5 : 0.1) * h;
  if (!(std::abs(memory_.last_passage - t) < near)) {
    note_passage(t, mechanics_.last_solve().reciprocal_condition);
  } else if (memory_.is_foreseen && !passages.first.empty() && passages.first.size() == passages.count) {
    passages.first.back().time = t;
  }
  memory_.last_passage = t;
  memory_.is_foreseen = false;
  memory_.is_at_one = true;  // should this place still be near: it is the same one
}

void SingularPlaces::note_passage(double t, double reciprocal_condition) {
  SingularPassages& passages = report_.singular_passages;
  if (++passages.count == 1) passages.first.reserve(SingularPassages::most_kept);  // here alone
  if (passages.first.size() < SingularPassages::most_kept) passages.first.push_back({t, reciprocal_condition});
}

/// The last one, which was foreseen: K has not come to it.
void SingularPlaces::withdraw_passage() {
  SingularPassages& passages = report_.singular_passages;
  if (passages.first.size() == passages.count) passages.first.pop_back();
  --passages.count;
  memory_.last_passage = std::numeric_limits<double>::quiet_NaN();
}

void SingularPlaces::forget_approaches() {
  memory_.approaches = 0;
  memory_.coasting_error = std::numeric_limits<double>::infinity();
}

void SingularPlaces::note_rank(double t) {
  RankChanges& changes = report_.rank_changes;
  if (mechanics_.rank() == changes.now) return;
  changes.now = mechanics_.rank();
  ++changes.count;
  if (changes.first.size() < RankChanges::most_kept) changes.first.push_back({t, changes.now});
}

/// Measured by a regular S: masses that differ make S ill-conditioned though K has its rank.
bool SingularPlaces::is_at_one() const {
  constexpr double nearly_0 = 1e-9;
  return mechanics_.last_solve().reciprocal_condition < nearly_0 * regular_;
}

bool SingularPlaces::have_surprised() const {
  constexpr double fall = 1e-3;
  return monitor_ != nullptr && memory_.approaches == 0 && mechanics_.rank() == report_.rank_changes.now &&
         mechanics_.last_solve().reciprocal_condition < fall * memory_.forecast.reciprocal_condition();
}

double SingularPlaces::coasting_length(double t_before, double t) const {
  const double ahead = memory_.forecast.time() - t, before = t - t_before;
  return is_coasting() ? before * std::pow(0.5, memory_.approaches) : ahead + 0.5 * std::max(ahead, 0.5 * before);
}

Outcome SingularPlaces::explain_stop(double t) const {
  return {Status::StepTooSmall, "constraints depend on each other near t = " + text(memory_.forecast.time()) +
                                    ", and no step from t = " + text(t) +
                                    " leads past that place within the tolerance"};
}

StepResult SingularPlaces::coast(Scheme& scheme, const State& before, const State& from, bool takes_least_error,
                                 State* to) {
  constexpr double allowed_error = 10.0;  // over the tolerance; the estimate is of a lower order
  SingularForecast& forecast = memory_.forecast;
  const Coasting::How how{.follows_quintic = scheme.knows_acceleration() && scheme.order() > 2,
                          .ends_there = forecast.lies_near(to->t, to->t - from.t)};
  if (!follows_ && !is_coasting()) remember(from.t);
  const bool by_itself = !how.ends_there && !is_coasting() && scheme.sees_through(from);
  StepResult step =
      by_itself ? scheme.step(from, to->t - from.t, to) : coasting_.step(mechanics_, options_, before, from, how, to);
  if (!step.outcome.ok()) return step;
  // What the polynomial misses falls with the fifth power of its length. What the states at hand miss is divided by the
  // singular value, and grows on the way to 0. Where an error falls less than the length it is about the least.
  constexpr double nearly_rounding = 1e-6, most_missed = 100.0;
  const double error = step.error / (to->t - from.t);
  const bool is_least = takes_least_error && step.error <= std::max(most_missed, nearly_rounding / options_.rtol);
  memory_.pays_to_approach = error < memory_.coasting_error;
  if (scheme.is_adaptive() && !(step.error <= allowed_error || is_least)) {
    memory_.coasting_error = error;
    return step;
  }
  step.error = 0.0;
  // What a step passes by itself is found where it ends.
  if (!by_itself && forecast.time() != memory_.last_passage) {
    note_passage(forecast.time(), forecast.reciprocal_condition());
    memory_.last_passage = forecast.time();
    memory_.is_foreseen = true;
  }
  memory_.is_in_the_way = false;
  forget_approaches();
  if (step.is_settled) forecast.forget();
  return step;
}

}  // namespace tanor
