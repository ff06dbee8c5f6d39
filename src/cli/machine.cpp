#include "cli/machine.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <thread>

namespace tanor::cli {

namespace {

/// A function of a library that may be loaded in this process, or null.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void keep_blas_serial() {
  // A setting of the whole process: the program may make it, the library never (its host may need BLAS threads).
  if (auto* set_num_threads = find_function<void(int)>("openblas_set_num_threads")) set_num_threads(1);
}

int count_threads() {
  if (auto* get_max_threads = find_function<int()>("omp_get_max_threads")) return get_max_threads();
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

}  // namespace tanor::cli
