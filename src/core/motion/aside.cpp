#include "motion/aside.hpp"

#include <span>
#include <vector>

namespace tanor::detail {

/// The solve at the state finds again what follows from it: K, its factor and the forces. It begins with the numbers
/// that the first one began with, and the numbers that it leaves are replaced by those that the first one left.
Outcome solve_aside(Mechanics& mechanics, const IntegrationOptions& options, const State& state,
                    const std::function<void()>& work, AsideMemory* memory) {
  EventFunctions* const events = mechanics.events();
  RoundingGroups* const rounding = mechanics.rounding_groups();
  const auto exchange = [&](Memory numbers) {
    mechanics.exchange_memory(numbers);
    if (rounding != nullptr) rounding->exchange_allowance(numbers);
  };
  const std::vector<int> modes = events != nullptr ? events->discrete_state() : std::vector<int>{};
  auto& [known, a] = *memory;
  known.clear();
  exchange(Memory(&known));

  work();

  if (events != nullptr) events->restore_discrete_state(modes);
  exchange(Memory(std::span<const double>(known)));
  a.resize(mechanics.size());
  Outcome found = mechanics.linearise(state.t, state.x.data());
  if (found.ok()) found = mechanics.accelerations(state.at(), options.request(Gradients::Keep), a.data());
  exchange(Memory(std::span<const double>(known)));
  return found;
}

}  // namespace tanor::detail
