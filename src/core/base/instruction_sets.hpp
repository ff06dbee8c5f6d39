#pragma once

#include <atomic>
#include <cstddef>
#include <type_traits>

#include "base/pack.hpp"

/// \file Compiles the body of a hot loop once for each instruction set and chooses one at run time. Packaged binaries
/// are built for the baseline of their architecture, which is too slow for hot loops.

namespace tanor::detail {

/// Instruction sets: Avx512 is x86-64-v4, Avx2 is x86-64-v3.
enum class InstructionSet { Unchosen, Baseline, Avx2, Avx512 };

extern std::atomic<InstructionSet> chosen_instruction_set;
InstructionSet choose_instruction_set();

/// Returns the best instruction set of the processor, or the one that the environment variable TANOR_ISA named at the
/// first call. Throws InputError if TANOR_ISA names no instruction set, or one that is not available here.
inline InstructionSet instruction_set() {
  const InstructionSet chosen = chosen_instruction_set.load(std::memory_order_relaxed);
  return chosen != InstructionSet::Unchosen ? chosen : choose_instruction_set();
}

/// Returns "baseline", "avx2" or "avx512", or "none yet" for Unchosen.
const char* name_of(InstructionSet set);

/// Runs the body. A body that takes a type argument gets PackIn<width>.
template <std::size_t width, class Body>
auto run_in(Body& body) {
  using Lanes = std::type_identity<PackIn<width>>;
  if constexpr (std::is_invocable_v<Body&, Lanes>) {
    return body(Lanes{});
  } else {
    return body();
  }
}

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__) && !defined(TANOR_NATIVE)
#define TANOR_HAS_INSTRUCTION_SETS 1

// "flatten" compiles everything that the body calls for the same instruction set, apart from nested dispatches. The
// code made for an instruction set stays in these functions, so that it cannot replace an inline function that other
// code calls. Each function runs its own copy of the body, so the compiler knows that no number which the body stores
// is a member of the body.
template <class Body>
[[gnu::target("arch=x86-64-v4"), gnu::flatten, gnu::noinline]] auto run_avx512(const Body& body) {
  Body own = body;
  return run_in<8>(own);
}
template <class Body>
[[gnu::target("arch=x86-64-v3"), gnu::flatten, gnu::noinline]] auto run_avx2(const Body& body) {
  Body own = body;
  return run_in<4>(own);
}
template <class Body>
[[gnu::flatten, gnu::noinline]] auto run_baseline(const Body& body) {
  Body own = body;
  return run_in<2>(own);
}

/// Runs the body, which is compiled once for each instruction set. The body captures small values by value, since
/// anything that it holds by reference might change with every number that it stores. It captures what owns memory by
/// reference.
///
/// gcc's target_clones are not used: they are chosen while libraries are loaded, before anybody can read the
/// environment or throw.
template <class Body>
auto dispatch(const Body& body) {
  static_assert(std::is_trivially_copyable_v<Body>, "capture what owns memory by reference");
  switch (instruction_set()) {
    case InstructionSet::Avx512:
      return run_avx512(body);
    case InstructionSet::Avx2:
      return run_avx2(body);
    default:
      return run_baseline(body);
  }
}
#else
#define TANOR_HAS_INSTRUCTION_SETS 0

/// Runs the body, which is compiled for the instruction set of the whole build.
template <class Body>
auto dispatch(Body body) {
  static_assert(std::is_trivially_copyable_v<Body>, "capture what owns memory by reference");
#if defined(__AVX512F__)
  return run_in<8>(body);
#elif defined(__AVX__)
  return run_in<4>(body);
#else
  return run_in<2>(body);
#endif
}
#endif

}  // namespace tanor::detail
