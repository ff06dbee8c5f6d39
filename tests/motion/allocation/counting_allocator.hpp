#pragma once

#include <cstddef>

namespace tanor::allocation {

/// Counts what every thread asks malloc, calloc, realloc, aligned_alloc, posix_memalign or operator new for, from its
/// construction on. The whole program has one heap: link counting_allocator.cpp.
class AllocationCounter {
 public:
  AllocationCounter();
  std::size_t count() const;
  /// Held by the program now, more than at the construction.
  std::ptrdiff_t bytes() const;

 private:
  std::size_t before_, held_before_;
};

}  // namespace tanor::allocation
