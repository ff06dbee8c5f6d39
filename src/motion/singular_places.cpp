#include "motion/singular_places.hpp"

#include <algorithm>
#include <cmath>
#include <string>
#include <type_traits>

#include "system/text.hpp"

namespace tanor {

void SingularPlaces::begin(double t) {
  forget();
  regular_ = 1.0 / mechanics_.mass_ratio();
  report_.reciprocal_condition = mechanics_.last_solve().reciprocal_condition;
  report_.reciprocal_condition_time = t;
  report_.rank_changes.start = report_.rank_changes.now = mechanics_.rank();
  note(t, true);
}

/// The first comparison knows no K before: it only remembers the one at hand.
void SingularPlaces::resume() {
  if (follows_ && !std::isnan(memory_.compared_time)) (void)mechanics_.find_passage(true);
}

/// visit(number) for all that the next steps depend on.
template <class M, class Visit>
void SingularPlaces::for_each_number(M& memory, const Visit& visit) {
  memory.forecast.for_each_number(visit);
  visit(memory.is_coasting);
  visit(memory.is_at_one);
  visit(memory.is_in_the_way);
  visit(memory.approaches);
  visit(memory.coasting_error);
  visit(memory.last_passage);
  visit(memory.compared_time);
}

void SingularPlaces::write(std::vector<double>* numbers) const {
  numbers->clear();
  if (!mechanics_.may_lose_rank()) return;
  numbers->push_back(regular_);
  for_each_number(memory_, [&](const auto& number) { numbers->push_back(static_cast<double>(number)); });
}

void SingularPlaces::restore(std::span<const double> numbers) {
  std::size_t count = mechanics_.may_lose_rank() ? 1 : 0;
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

void SingularPlaces::note(double t, bool is_settled) {
  memory_.is_coasting = !is_settled;
  if (!is_settled) return;
  const double reciprocal_condition = mechanics_.last_solve().reciprocal_condition;
  if (reciprocal_condition < report_.reciprocal_condition) {
    report_.reciprocal_condition = reciprocal_condition;
    report_.reciprocal_condition_time = t;
  }
  if (!mechanics_.may_lose_rank()) return;
  if (mechanics_.rank() != report_.rank_changes.now) memory_.forecast.forget();
  regular_ = std::max(regular_, reciprocal_condition);
  memory_.forecast.add(t, reciprocal_condition, regular_);
  const bool lies_ahead = memory_.forecast.time() > t && std::isfinite(memory_.forecast.time());
  memory_.is_in_the_way = lies_ahead && (memory_.is_in_the_way || memory_.approaches > 0);
  if (!lies_ahead) forget_approaches();
  if (follows_) find_passage(t);
  if (is_at_one()) {
    note_passage(t, reciprocal_condition, memory_.is_at_one);
    memory_.last_passage = t;
  }
  memory_.is_at_one = is_at_one();
  note_rank(t);
}

/// One that lies inside the last step, unless it is known.
void SingularPlaces::find_passage(double t) {
  const double from = memory_.compared_time, fraction = mechanics_.find_passage(std::isnan(from));
  memory_.compared_time = t;
  if (fraction < 0.0) return;
  const double time = from + fraction * (t - from);
  const bool is_known = std::abs(memory_.last_passage - time) < 0.5 * (t - from);
  if (!is_known) note_passage(time, mechanics_.last_solve().reciprocal_condition, false);
  memory_.last_passage = time;
  memory_.is_at_one = true;  // should this place still be near: it is the same one
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

void SingularPlaces::note_passage(double t, double reciprocal_condition, bool is_the_last_one) {
  SingularPassages& passages = report_.singular_passages;
  const bool is_last_kept = !passages.first.empty() && passages.first.size() == passages.count;
  if (!is_the_last_one) {
    ++passages.count;
    if (passages.first.size() < SingularPassages::most_kept) passages.first.push_back({t, reciprocal_condition});
  } else if (is_last_kept && reciprocal_condition < passages.first.back().reciprocal_condition) {
    passages.first.back() = {t, reciprocal_condition};
  }
}

/// Measured by a regular S: masses that differ make S ill-conditioned though K has its rank.
bool SingularPlaces::is_at_one() const {
  constexpr double nearly_0 = 1e-9;
  return mechanics_.last_solve().reciprocal_condition < nearly_0 * regular_;
}

bool SingularPlaces::have_surprised() const {
  constexpr double fall = 1e-3;
  return mechanics_.may_lose_rank() && memory_.approaches == 0 && mechanics_.rank() == report_.rank_changes.now &&
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

StepResult SingularPlaces::coast(Scheme& scheme, const State& before, const State& from, State* to) {
  constexpr double allowed_error = 10.0;  // over the tolerance; the estimate is of a lower order
  SingularForecast& forecast = memory_.forecast;
  const Coasting how{.follows_quintic = scheme.knows_acceleration() && scheme.order() > 2,
                     .ends_there = forecast.lies_near(to->t, to->t - from.t)};
  const bool by_itself = !how.ends_there && !is_coasting() && scheme.sees_through(from);
  StepResult step =
      by_itself ? scheme.step(from, to->t - from.t, to) : tanor::coast(mechanics_, options_, before, from, how, to);
  if (!step.outcome.ok()) return step;
  // From halfway there the error is 1/32 of the one before, or it is rounding; of the state: never that much.
  constexpr double most_rounding = 1e-6;
  const bool is_rounding = step.error > 0.25 * memory_.coasting_error && step.error * options_.rtol <= most_rounding;
  if (scheme.is_adaptive() && !(step.error <= allowed_error || is_rounding)) {
    memory_.coasting_error = step.error;
    return step;
  }
  step.error = 0.0;
  // What a step passes by itself is found where it ends.
  if (!by_itself && forecast.time() != memory_.last_passage)
    note_passage(forecast.time(), forecast.reciprocal_condition(), false);
  if (!by_itself) memory_.last_passage = forecast.time();
  memory_.is_in_the_way = false;
  forget_approaches();
  if (step.is_settled) forecast.forget();
  return step;
}

}  // namespace tanor
