#pragma once

#include <algorithm>
#include <cstddef>

namespace tanor::detail {

/// Visits elements that are scattered over the memory, and calls for those to come. If all of them fit into the second
/// cache, the processor orders its reads early enough by itself.
///
/// `address(i)` returns the place of element i of all `count` ones, which has `size` bytes and may lie in two lines of
/// the memory. The call does visit(i) for i in [begin, end).
template <class Address, class Visit>
[[gnu::always_inline]] inline void visit_scattered(std::size_t begin, std::size_t end, std::size_t count,
                                                   std::size_t size, const Address& address, const Visit& visit) {
  constexpr std::size_t worth_calling = 1 << 15, ahead = 160;  // elements; bench/constrainer
  static_assert(ahead < worth_calling);
  const std::size_t end_calls = count < worth_calling ? begin : std::clamp(count - ahead, begin, end);
  std::size_t i = begin;
  for (; i < end_calls; ++i) {
    const char* const next = reinterpret_cast<const char*>(address(i + ahead));
    __builtin_prefetch(next);
    __builtin_prefetch(next + size - 1);
    visit(i);
  }
  for (; i < end; ++i) visit(i);
}

}  // namespace tanor::detail
