#include "base/instruction_sets.hpp"

#include <array>
#include <cstdlib>
#include <string>

#include <tanor/error.hpp>

namespace tanor::detail {
namespace {

InstructionSet find_best() {
#if TANOR_HAS_INSTRUCTION_SETS
  if (__builtin_cpu_supports("x86-64-v4")) return InstructionSet::Avx512;
  if (__builtin_cpu_supports("x86-64-v3")) return InstructionSet::Avx2;
#endif
  return InstructionSet::Baseline;
}

InstructionSet choose() {
  const InstructionSet best = find_best();
  const char* const given = std::getenv("TANOR_ISA");
  if (given == nullptr || *given == '\0') return best;
  for (const InstructionSet set : {InstructionSet::Avx512, InstructionSet::Avx2, InstructionSet::Baseline}) {
    if (std::string(name_of(set)) != given) continue;
    if (set <= best) return set;
    throw InputError("",
                     "TANOR_ISA asks for " + std::string(given) + ", which " +
                         (TANOR_HAS_INSTRUCTION_SETS ? "this processor does not have" : "this build does not have") +
                         "; the best one here is " + name_of(best));
  }
  throw InputError("", "TANOR_ISA must be avx512, avx2 or baseline, not '" + std::string(given) + "'");
}

}  // namespace

constinit std::atomic<InstructionSet> chosen_instruction_set{InstructionSet::Unchosen};

InstructionSet choose_instruction_set() {
  const InstructionSet chosen = choose();
  chosen_instruction_set.store(chosen, std::memory_order_relaxed);
  return chosen;
}

const char* name_of(InstructionSet set) {
  constexpr std::array<const char*, 4> names{"none yet", "baseline", "avx2", "avx512"};
  return names[static_cast<std::size_t>(set)];
}

}  // namespace tanor::detail
