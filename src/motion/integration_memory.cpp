#include <string>
#include <utility>

#include "base/text.hpp"
#include "motion/integration.hpp"

/// \file What the next step of Integration depends on beside the state, to and from a snapshot.
namespace tanor {

namespace {

/// Calls visit(number) for all of a state but the works done.
template <class S, class Visit>
void for_each_number(S& state, const Visit& visit) {
  visit(state.t);
  for (double Power::*const part : {&Power::supports, &Power::forces, &Power::friction}) visit(state.power.*part);
  for (auto* array : {&state.x, &state.v, &state.a}) {
    for (auto& number : *array) visit(number);
  }
}

}  // namespace

void Integration::write(Snapshot* snapshot) {
  snapshot->next_step = next_step;
  snapshot->last_error = control_.last_error();
  snapshot->advance_begin = last_advance_.begin;
  snapshot->advance_end = last_advance_.end;
  snapshot->drive_memory = drives_.memory();
  snapshot->discrete_state = events_.discrete_state();
  snapshot->event_slopes = events_.slopes();
  snapshot->memory.clear();
  Memory memory(&snapshot->memory);
  exchange_memory(memory);
  scheme_->exchange_memory(memory);
  singular_.write(&snapshot->singular_memory);
  if (scheme_->is_adaptive()) {
    snapshot->rounding_memory = rounding_.memory();
    snapshot->stiff_memory = stiff_steps_.memory();
  }
  std::vector<double>& before = snapshot->state_before;
  before.clear();
  if (!trial_.is_before || !singular_.may_extrapolate()) return;
  before.push_back(control_.is_after_rejection());
  for_each_number(trial_.state, [&](double number) { before.push_back(number); });
  before.insert(before.end(), state.a.begin(), state.a.end());
}

/// Exchanges all memory but the scheme's: what the solve that completes a restored state may change.
void Integration::exchange_memory(Memory& memory) {
  mechanics_.exchange_memory(memory);
  if (!mechanics_.keeps_variables()) memory.exchange(state.x, state.v);
  memory.exchange(state.a, state.power.supports, state.power.forces, state.power.friction);
  turns_.exchange_memory(memory);
  events_.exchange_memory(memory);
}

/// Keeps what iterations began with: where several accelerations are near to each other, it decides which one is found.
void Integration::keep_memory() {
  good_memory_.clear();
  if (mechanics_.last_solve().friction.uniqueness != Uniqueness::Several) return;
  Memory memory(&good_memory_);
  exchange_memory(memory);
}

void Integration::restore_good_memory() {
  if (good_memory_.empty()) return;
  Memory memory{std::span<const double>(good_memory_)};
  exchange_memory(memory);
}

void Integration::restore(const Snapshot& snapshot) {
  const std::vector<double>& before = snapshot.state_before;
  if (const std::size_t expected = 5 + 4 * mechanics_.size(); !before.empty() && before.size() != expected) {
    throw InputError("/snapshot/state_before",
                     "holds " + std::to_string(before.size()) + " numbers, not " + std::to_string(expected));
  }
  stiff_steps_.restore(snapshot.stiff_memory);  // which says what steps
  std::unique_ptr<Scheme> scheme = make_scheme(is_stiff() ? Method::Radau5 : method_, options_, mechanics_);
  if (!snapshot.memory.empty()) {
    std::vector<double> own;
    Memory memory(&own);
    exchange_memory(memory);
    scheme->exchange_memory(memory);
    if (own.size() != snapshot.memory.size()) Memory::refuse();
  }
  singular_.restore(snapshot.singular_memory);
  rounding_.restore(snapshot.rounding_memory);
  events_.restore_discrete_state(snapshot.discrete_state);
  next_step = snapshot.next_step;
  scheme_ = std::move(scheme);  // which remembers no other motion
  drives_.follow(*scheme_);
  control_ = StepControl(scheme_->estimate_order(), snapshot.last_error, !before.empty() && before[0] != 0.0);
  last_advance_ = {snapshot.advance_begin, snapshot.advance_end};
  drives_.restore(snapshot.time, snapshot.drive_memory);
  events_.restore(snapshot.report.events, snapshot.report.last_event, snapshot.event_slopes);
  trial_.is_before = !before.empty();
  if (!trial_.is_before) return;
  std::size_t next = 1;
  for_each_number(trial_.state, [&](double& number) { number = before[next++]; });
  state.a.assign(before.begin() + static_cast<std::ptrdiff_t>(next), before.end());
}

void Integration::restore_memory(const Snapshot& snapshot) {
  if (snapshot.memory.empty()) return;
  Memory memory{std::span(snapshot.memory)};
  exchange_memory(memory);
  scheme_->exchange_memory(memory);
  memory.finish();
}

void Integration::resume(const Snapshot& snapshot) {
  if (!snapshot.memory.empty()) {
    Memory memory{std::span(snapshot.memory)};
    exchange_memory(memory);
  }
  if (!trial_.is_before) trial_.state = state;
  watch_.forget();
  singular_.resume();
  keep_memory();
}

}  // namespace tanor
