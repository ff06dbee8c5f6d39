/// Passes to libFuzzer what it needs of code that GCC compiled: a counter for each block, found by the address of the
/// call. Comparisons (trace-cmp) go to it without help.

#include <cstdint>

namespace {

constexpr std::uintptr_t num_counters = 1 << 16;
__attribute__((section("__libfuzzer_extra_counters"))) std::uint8_t counters[num_counters];

}  // namespace

extern "C" __attribute__((visibility("default"))) void __sanitizer_cov_trace_pc() {
  const auto place = reinterpret_cast<std::uintptr_t>(__builtin_return_address(0));
  std::uint8_t& counter = counters[(place ^ (place >> 16)) % num_counters];
  if (counter < 255) ++counter;
}

/// Comparisons of real numbers have no counterpart in libFuzzer; the blocks that follow tell them apart.
extern "C" __attribute__((visibility("default"))) void __sanitizer_cov_trace_cmpf(float, float) {}
extern "C" __attribute__((visibility("default"))) void __sanitizer_cov_trace_cmpd(double, double) {}
