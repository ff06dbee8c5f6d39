#include <utility>

#include "base/text.hpp"
#include "motion/integration.hpp"

/// \file Exchange of a snapshot with what the next step of Integration depends on besides the state.
namespace tanor::detail {

namespace {

/// Returns the numbers that a part exchanges.
template <class Exchange>
std::vector<double> write_numbers(const Exchange& exchange) {
  std::vector<double> numbers;
  Memory memory(&numbers);
  exchange(memory);
  return numbers;
}

template <class Part>
std::vector<double> numbers_of(Part& part) {
  return write_numbers([&](Memory& memory) { part.exchange_memory(memory); });
}

/// Gives the numbers back to the part. Throws InputError with the place `where` in the snapshot if their count is not
/// that of the part.
template <class Exchange>
void read_numbers(std::span<const double> numbers, const char* where, const Exchange& exchange) {
  if (const std::size_t wanted = write_numbers(exchange).size(); numbers.size() != wanted)
    throw InputError(where, "holds " + text(numbers.size()) + " numbers, not " + text(wanted));
  Memory memory(numbers);
  exchange(memory);
}

template <class Part>
void give_back(std::span<const double> numbers, const char* where, Part* part) {
  read_numbers(numbers, where, [&](Memory& memory) { part->exchange_memory(memory); });
}

}  // namespace

void Integration::write_progress(Snapshot* snapshot) const {
  snapshot->next_step = next_step;
  snapshot->last_error = control_.last_error();
  snapshot->advance_begin = last_advance_.begin;
  snapshot->advance_end = last_advance_.end;
}

void Integration::write(Snapshot* snapshot) {
  write_progress(snapshot);
  snapshot->drive_memory = numbers_of(drives_);
  snapshot->discrete_state = trial_.events.discrete_state();
  snapshot->event_slopes = trial_.events.slopes();
  snapshot->memory = write_numbers([&](Memory& memory) {
    exchange_memory(memory);
    scheme_->exchange_memory(memory);
  });
  snapshot->singular_memory = numbers_of(singular_);
  if (scheme_->is_adaptive()) snapshot->rounding_memory = numbers_of(rounding_);
  if (scheme_->is_adaptive() && options_.method == Method::Auto) snapshot->stiff_memory = numbers_of(stiff_steps_);
  bool is_after_rejection = control_.is_after_rejection();
  if (trial_.is_before && singular_.may_extrapolate())
    snapshot->state_before = write_numbers([&](Memory& memory) { exchange_states(memory, &is_after_rejection); });
}

/// Exchanges the previous state and what a step knows of it and of the present one.
void Integration::exchange_states(Memory& memory, bool* is_after_rejection) {
  State& before = trial_.state;
  memory.exchange(*is_after_rejection, before.t, before.power.supports, before.power.forces, before.power.friction,
                  before.x, before.v, before.a, state.a);
}

/// Exchanges all memory except the scheme's; the solve that completes a restored state may change it.
void Integration::exchange_memory(Memory& memory) {
  mechanics_.exchange_memory(memory);
  if (!mechanics_.keeps_variables()) memory.exchange(state.x, state.v);
  memory.exchange(state.a, state.power.supports, state.power.forces, state.power.friction);
  state.reactions.exchange_memory(memory);
  turns_.exchange_memory(memory);
  trial_.events.exchange_memory(memory);
}

/// Keeps what iterations started from. If several accelerations are possible, this decides which one is found.
void Integration::keep_memory() {
  good_memory_.clear();
  if (state.report.friction.uniqueness != Uniqueness::Several) return;
  Memory memory(&good_memory_);
  exchange_memory(memory);
}

void Integration::restore_good_memory() {
  if (good_memory_.empty()) return;
  Memory memory{std::span<const double>(good_memory_)};
  exchange_memory(memory);
}

void Integration::restore(const Snapshot& snapshot) {
  // The stiffness memory comes first, since it determines the scheme and so the memory that belongs to it.
  if (!snapshot.stiff_memory.empty()) give_back(snapshot.stiff_memory, "/snapshot/stiff_memory", &stiff_steps_);
  std::unique_ptr<Scheme> scheme = make_scheme(is_stiff() ? Method::Radau5 : method_, options_, mechanics_);
  if (!snapshot.memory.empty()) {
    const std::vector<double> own = write_numbers([&](Memory& memory) {
      exchange_memory(memory);
      scheme->exchange_memory(memory);
    });
    if (own.size() != snapshot.memory.size()) Memory::refuse();
  }
  singular_.forget();
  const bool is_whole = !snapshot.memory.empty();  // else it holds only what does not depend on the processes
  if (is_whole) give_back(snapshot.singular_memory, "/snapshot/singular_memory", &singular_);
  if (!snapshot.rounding_memory.empty()) give_back(snapshot.rounding_memory, "/snapshot/rounding_memory", &rounding_);
  if (is_whole) trial_.events.restore_discrete_state(snapshot.discrete_state);
  next_step = snapshot.next_step;
  scheme_ = std::move(scheme);  // the new scheme has no memory of another motion
  drives_.follow(*scheme_);
  last_advance_ = {snapshot.advance_begin, snapshot.advance_end};
  drives_.begin(snapshot.time);
  if (!snapshot.drive_memory.empty()) give_back(snapshot.drive_memory, "/snapshot/drive_memory", &drives_);
  trial_.events.restore(snapshot.report.events, snapshot.report.last_event, snapshot.event_slopes);
  trial_.is_before = !snapshot.state_before.empty();
  bool is_after_rejection = false;
  if (trial_.is_before) {
    read_numbers(snapshot.state_before, "/snapshot/state_before",
                 [&](Memory& memory) { exchange_states(memory, &is_after_rejection); });
  }
  control_ = StepControl(scheme_->estimate_order(), snapshot.last_error, is_after_rejection);
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
  trial_.watch.begin(state.t);
  singular_.resume(state.t);
  keep_memory();
}

}  // namespace tanor::detail
