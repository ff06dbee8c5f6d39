#include "allocation/counting_allocator.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>

#include <malloc.h>

// These are glibc's own names behind malloc. The functions below take the place of its public ones, also in libraries
// (operator new calls malloc).
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

std::atomic<std::size_t> allocations{0}, held{0};

void* take(void* block) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  held.fetch_add(malloc_usable_size(block), std::memory_order_relaxed);
  return block;
}
void give_back(void* block) {
  held.fetch_sub(malloc_usable_size(block), std::memory_order_relaxed);
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
  return take(__libc_malloc(size));
}
void* calloc(std::size_t count, std::size_t size) {
  return take(__libc_calloc(count, size));
}
void* realloc(void* block, std::size_t size) {
  give_back(block);
  return take(__libc_realloc(block, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  return take(__libc_memalign(alignment, size));
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  *block = take(__libc_memalign(alignment, size));
  return *block != nullptr ? 0 : ENOMEM;
}
void free(void* block) {
  give_back(block);
  __libc_free(block);
}

}  // extern "C"

namespace tanor::allocation {

AllocationCounter::AllocationCounter() : before_(allocations.load()), held_before_(held.load()) {}
std::size_t AllocationCounter::count() const {
  return allocations.load() - before_;
}
std::ptrdiff_t AllocationCounter::bytes() const {
  return static_cast<std::ptrdiff_t>(held.load() - held_before_);
}

}  // namespace tanor::allocation
