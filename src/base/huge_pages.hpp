#pragma once

#include <cstddef>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

/// \file Arrays that are swept through from memory. With pages of 4 KiB the machine looks up an address for every 512
/// numbers: a solve of a large net takes a tenth longer, and more in a virtual machine.
namespace tanor {

template <class T>
struct HugePageAllocator {
  using value_type = T;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}  // implicit, as the standard asks of allocators

  T* allocate(std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    void* const memory = ::operator new(bytes, alignment_of(count));
#if defined(__linux__)
    // Advice alone: where the system has no such pages, nothing changes.
    if (is_large(count)) madvise(memory, bytes / page * page, MADV_HUGEPAGE);
#endif
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, std::size_t count) {
    ::operator delete(memory, alignment_of(count));
  }

  template <class U>
  bool operator==(const HugePageAllocator<U>&) const {
    return true;
  }

 private:
  static constexpr std::size_t page = std::size_t{1} << 21, cache_line = 64;

  static bool is_large(std::size_t count) {
    return count * sizeof(T) >= 2 * page;
  }
  static std::align_val_t alignment_of(std::size_t count) {
    return std::align_val_t{is_large(count) ? page : cache_line};
  }
};

/// std::vector on pages of 2 MiB from 4 MiB on.
template <class T>
using LargeArray = std::vector<T, HugePageAllocator<T>>;

}  // namespace tanor
