#pragma once

#include <cstddef>

namespace tanor::allocation {

/// Counts the calls of all threads to malloc, calloc, realloc, aligned_alloc, posix_memalign or operator new since its
/// construction. The whole program has one heap: link counting_allocator.cpp.
class AllocationCounter {
 public:
  AllocationCounter();
  std::size_t count() const;
  /// Returns by how much the bytes that the program holds have grown since the construction.
  std::ptrdiff_t bytes() const;

 private:
  std::size_t before_, held_before_;
};

}  // namespace tanor::allocation
