#pragma once

#include <cstddef>
#include <vector>

/// \file Arrays that are read from memory in whole. With pages of 4 KiB the machine translates an address for every 512
/// numbers: a solve of a large net takes a tenth longer, and more in a virtual machine.
namespace tanor::detail {

/// Allocates memory that begins at a cache line. From 4 MiB on it has pages of 2 MiB if the system offers them.
void* allocate_pages(std::size_t bytes);
void release_pages(void* memory, std::size_t bytes);

template <class T>
struct HugePageAllocator {
  using value_type = T;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}  // implicit, as the standard asks of allocators

  T* allocate(std::size_t count) { return static_cast<T*>(allocate_pages(count * sizeof(T))); }
  void deallocate(T* memory, std::size_t count) { release_pages(memory, count * sizeof(T)); }

  template <class U>
  bool operator==(const HugePageAllocator<U>&) const {
    return true;
  }
};

template <class T>
using LargeArray = std::vector<T, HugePageAllocator<T>>;

}  // namespace tanor::detail
