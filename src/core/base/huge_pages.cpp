#include "base/huge_pages.hpp"

#include <new>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tanor::detail {

namespace {

constexpr std::size_t cache_line = 64, huge_page = std::size_t{1} << 21;

bool is_large(std::size_t bytes) {
  return bytes >= 2 * huge_page;
}

std::align_val_t alignment_of(std::size_t bytes) {
  return std::align_val_t{is_large(bytes) ? huge_page : cache_line};
}

}  // namespace

void* allocate_pages(std::size_t bytes) {
  void* const memory = ::operator new(bytes, alignment_of(bytes));
#if defined(__linux__)
  // If madvise fails, the array has small pages.
  if (is_large(bytes)) madvise(memory, bytes / huge_page * huge_page, MADV_HUGEPAGE);
#endif
  return memory;
}

void release_pages(void* memory, std::size_t bytes) {
  ::operator delete(memory, alignment_of(bytes));
}

}  // namespace tanor::detail
