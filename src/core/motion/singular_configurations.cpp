#include "motion/singular_configurations.hpp"

#include <algorithm>
#include <cmath>

#include "base/text.hpp"

namespace tanor::detail {

void SingularConfigurations::begin(double t) {
  forget();
  if (monitor_ != nullptr) regular_ = 1.0 / mechanics_.largest(monitor_->mass_ratio());
  report_.last_reciprocal_condition = mechanics_.reciprocal_condition();
  report_.nearest_to_singular = {report_.last_reciprocal_condition, t};
  report_.rank_changes.start = report_.rank_changes.now = mechanics_.rank();
  note_end(t);
}

void SingularConfigurations::resume(double t) {
  if (!std::isnan(memory_.remembered)) monitor_->remember_gradients();
  if (!is_extrapolating()) note_rank(t);
}

void SingularConfigurations::exchange_memory(Memory& memory) {
  if (monitor_ == nullptr) return;
  memory.exchange(regular_);
  memory_.forecast.exchange_memory(memory);
  memory.exchange(memory_.is_extrapolating, memory_.is_at_one, memory_.is_in_the_way, memory_.is_foreseen,
                  memory_.pays_to_approach, memory_.approaches, memory_.extrapolation_error, memory_.last_passage,
                  memory_.remembered);
}

// ---- the end of a step ----

void SingularConfigurations::note(Scheme& scheme, const State& from, const State& to, const StepResult& step) {
  memory_.is_extrapolating = !step.is_stabilized;
  if (!step.is_stabilized) return;
  if (!std::isnan(memory_.remembered) && to.t > from.t) {
    const double ratio = mechanics_.smallest(monitor_->compare_gradients());
    if (ratio < 0.0)
      find_passages(scheme, from, to, step.is_interpolated);
    else if (memory_.is_foreseen && ratio > 0.0 && ratio != 1.0)
      withdraw_passage();
  }
  memory_.is_foreseen = false;
  note_end(to.t);
}

/// Examines K at the present configuration of the mechanics.
void SingularConfigurations::note_end(double t) {
  note_nearest(t);
  if (monitor_ == nullptr) return;
  if (mechanics_.rank() != report_.rank_changes.now) memory_.forecast.forget();
  const double reciprocal_condition = mechanics_.reciprocal_condition();
  regular_ = std::max(regular_, reciprocal_condition);
  memory_.forecast.add(t, reciprocal_condition, regular_);
  const bool lies_ahead = memory_.forecast.lies_ahead_of(t);
  memory_.is_in_the_way = lies_ahead && (memory_.is_in_the_way || memory_.approaches > 0);
  if (!lies_ahead) forget_approaches();
  if (is_at_one()) note_at_one(t);
  memory_.is_at_one = is_at_one();
  if (follows_)
    remember(t);
  else
    memory_.remembered = std::numeric_limits<double>::quiet_NaN();
  note_rank(t);
}

void SingularConfigurations::note_nearest(double t) {
  report_.last_reciprocal_condition = mechanics_.reciprocal_condition();
  if (report_.last_reciprocal_condition < report_.nearest_to_singular.reciprocal_condition)
    report_.nearest_to_singular = {report_.last_reciprocal_condition, t};
}

/// Takes note that the step ended at a singular configuration, which is a new one or nearer to the last one than
/// before.
void SingularConfigurations::note_at_one(double t) {
  const double reciprocal_condition = mechanics_.reciprocal_condition();
  if (!memory_.is_at_one) {
    note_passage(t, reciprocal_condition);
  } else if (keeps_last_passage()) {
    auto& last = report_.singular_passages.first.back();
    if (reciprocal_condition < last.reciprocal_condition) last = {t, reciprocal_condition};
  }
  memory_.last_passage = t;
}

void SingularConfigurations::remember(double t) {
  monitor_->remember_gradients();
  memory_.remembered = t;
}

/// Searches the last step, whose ends reveal a passage. A step that began while the state was extrapolated had a
/// singular configuration right before it, too.
void SingularConfigurations::find_passages(Scheme& scheme, const State& from, const State& to, bool is_interpolated) {
  const double largest = std::max(memory_.forecast.reciprocal_condition(), mechanics_.reciprocal_condition());
  // A step that is near all the way is short, so that K turns little in it.
  const int pieces = largest < singular::near * regular_ ? 1 : singular::pieces_of_long_step;
  const double begin = memory_.remembered < from.t ? -0.5 : 0.0;
  const double h = to.t - from.t;
  finder_.find(*monitor_, DenseOutput(scheme, from, to, !is_interpolated), to, {begin, pieces, regular_},
               [this, h](double t) { note_found(t, h); });
}

// ---- the report ----

/// Takes note of a passage at t in a step of length h. It is a new one, or one that was foreseen or seen at a step's
/// end.
void SingularConfigurations::note_found(double t, double h) {
  if (memory_.is_foreseen) {
    if (keeps_last_passage()) report_.singular_passages.first.back().time = t;
  } else if (!(std::abs(memory_.last_passage - t) < singular::same * h)) {
    note_passage(t, mechanics_.reciprocal_condition());
  }
  memory_.last_passage = t;
  memory_.is_foreseen = false;
  memory_.is_at_one = true;  // if the step's end is still near, it is the same configuration
}

/// Returns true if the list holds the last passage. The count goes on when the list is full.
bool SingularConfigurations::keeps_last_passage() const {
  const SingularPassages& passages = report_.singular_passages;
  return !passages.first.empty() && passages.first.size() == passages.count;
}

void SingularConfigurations::note_passage(double t, double reciprocal_condition) {
  SingularPassages& passages = report_.singular_passages;
  if (++passages.count == 1) passages.first.reserve(SingularPassages::most_kept);  // the only allocation
  if (passages.first.size() < SingularPassages::most_kept) passages.first.push_back({t, reciprocal_condition});
}

/// Withdraws the last passage, which was foreseen but which K did not reach.
void SingularConfigurations::withdraw_passage() {
  SingularPassages& passages = report_.singular_passages;
  if (passages.first.size() == passages.count) passages.first.pop_back();
  --passages.count;
  memory_.last_passage = std::numeric_limits<double>::quiet_NaN();
}

void SingularConfigurations::note_rank(double t) {
  RankChanges& changes = report_.rank_changes;
  if (mechanics_.rank() == changes.now) return;
  changes.now = mechanics_.rank();
  ++changes.count;
  if (changes.first.size() < RankChanges::most_kept) changes.first.push_back({t, changes.now});
}

// ---- what comes next ----

/// Returns true at a singular configuration. S is compared with a regular S, since different masses make S
/// ill-conditioned even if K has full rank.
bool SingularConfigurations::is_at_one() const {
  return mechanics_.reciprocal_condition() < singular::reached * regular_;
}

bool SingularConfigurations::have_surprised() const {
  return monitor_ != nullptr && memory_.approaches == 0 && mechanics_.rank() == report_.rank_changes.now &&
         mechanics_.reciprocal_condition() < singular::surprise * memory_.forecast.reciprocal_condition();
}

void SingularConfigurations::forget_approaches() {
  memory_.approaches = 0;
  memory_.extrapolation_error = std::numeric_limits<double>::infinity();
}

double SingularConfigurations::extrapolation_length(double t_before, double t) const {
  const double ahead = memory_.forecast.time() - t, before = t - t_before;
  return is_extrapolating() ? before * std::pow(0.5, memory_.approaches) : ahead + 0.5 * std::max(ahead, 0.5 * before);
}

Outcome SingularConfigurations::explain_stop(double t) const {
  const auto [place, from] = texts_apart(std::array{memory_.forecast.time(), t});
  return {Status::StepTooSmall, "constraints depend on each other near t = " + place +
                                    ", and no step from t = " + from + " leads past that place within the tolerance"};
}

StepResult SingularConfigurations::extrapolate(Scheme& scheme, const State& before, const State& from,
                                               bool takes_least_error, State* to) {
  SingularForecast& forecast = memory_.forecast;
  const double h = to->t - from.t;
  const Extrapolation::How how{.follows_quintic = scheme.knows_acceleration() && scheme.order() > 2,
                               .ends_at_singularity = forecast.lies_near(to->t, h)};
  if (!follows_ && !is_extrapolating()) remember(from.t);
  const bool by_itself = !how.ends_at_singularity && !is_extrapolating() && scheme.sees_through(from);
  StepResult step =
      by_itself ? scheme.step(from, h, to) : extrapolation_.step(mechanics_, options_, before, from, how, to);
  if (!step.outcome.ok()) return step;
  // The error of the polynomial falls with the fifth power of its length. The error of the known states is divided by
  // sigma, and grows as sigma falls to 0. The least error is reached where it falls less than the length.
  const double error = step.error / h;
  const double least = std::max(singular::most_missed, singular::most_missed_of_velocity / options_.rtol);
  const bool is_least = takes_least_error && step.error <= least;
  memory_.pays_to_approach = error < memory_.extrapolation_error;
  if (scheme.is_adaptive() && !(step.error <= singular::allowed_error || is_least)) {
    memory_.extrapolation_error = error;
    return step;
  }
  step.error = 0.0;
  // A passage of the scheme's own step is found at its end.
  if (!by_itself && forecast.time() != memory_.last_passage) {
    note_passage(forecast.time(), forecast.reciprocal_condition());
    memory_.last_passage = forecast.time();
    memory_.is_foreseen = true;
  }
  memory_.is_in_the_way = false;
  forget_approaches();
  if (step.is_stabilized) forecast.forget();
  return step;
}

}  // namespace tanor::detail
