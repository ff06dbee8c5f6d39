#include "cli/machine.hpp"

#include <dlfcn.h>
#include <sys/mman.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <tanor/build_info.hpp>

namespace tanor::cli {

namespace {

/// Returns a function of a library that may be loaded in this process, or null.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void require_threads(int count) {
  const int others = (count > 0 ? count : count_threads()) - 1;
  std::promise<void> all_are_here;
  const std::shared_future<void> signal = all_are_here.get_future().share();
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(std::max(others, 0)));
  std::string failure;
  try {
    for (int k = 0; k < others; ++k) threads.emplace_back([signal] { signal.wait(); });
  } catch (const std::exception& error) {
    failure = "cannot start " + std::to_string(others + 1) + " threads: " + error.what();
  }
  all_are_here.set_value();
  for (std::thread& thread : threads) thread.join();
  if (!failure.empty()) throw std::runtime_error(failure);
}

void require_work_space_of_blas() {
  if (!build_info().has_suitesparse_qr) return;
  if (auto* set_threads = find_function<void(int)>("openblas_set_num_threads")) set_threads(1);
  constexpr std::size_t bytes = std::size_t{160} << 20;  // OpenBLAS maps 128 MiB
  void* const room = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) throw std::runtime_error("out of memory: none is left for the work space of BLAS");
  munmap(room, bytes);
  const int one = 1;
  const double number = 1.0;
  double square = 0.0;
  using Square = void(const char*, const char*, const int*, const int*, const double*, const double*, const int*,
                      const double*, double*, const int*);
  if (auto* add_square = find_function<Square>("dsyrk_"))
    add_square("U", "N", &one, &one, &number, &number, &one, &number, &square, &one);
}

int count_threads() {
  if (auto* get_max_threads = find_function<int()>("omp_get_max_threads")) return get_max_threads();
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace tanor::cli
