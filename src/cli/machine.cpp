#include "cli/machine.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <exception>
#include <future>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

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

int count_threads() {
  if (auto* get_max_threads = find_function<int()>("omp_get_max_threads")) return get_max_threads();
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace tanor::cli
