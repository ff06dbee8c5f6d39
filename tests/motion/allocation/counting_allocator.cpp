#include "motion/allocation/counting_allocator.hpp"

#include <atomic>
#include <cerrno>
#include <cstdlib>

// glibc's own names behind malloc: the functions below take the place of its public ones, in the libraries too
// (operator new calls malloc).
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}

namespace {

std::atomic<std::size_t> allocations{0};

void count_one() {
  allocations.fetch_add(1, std::memory_order_relaxed);
}

}  // namespace

extern "C" {

void* malloc(std::size_t size) {
  count_one();
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  count_one();
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  count_one();
  return __libc_realloc(block, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count_one();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  count_one();
  *block = __libc_memalign(alignment, size);
  return *block != nullptr ? 0 : ENOMEM;
}
void free(void* block) {
  __libc_free(block);
}

}  // extern "C"

namespace tanor::allocation {

AllocationCounter::AllocationCounter() : before_(allocations.load()) {}
std::size_t AllocationCounter::count() const {
  return allocations.load() - before_;
}

}  // namespace tanor::allocation
