#include "report/module.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>

#include <tanor/error.hpp>

namespace tanor::report {

namespace fs = std::filesystem;

void* load_function(const std::string& module, const char* symbol, const std::string& without) {
  Dl_info here{};
  const fs::path folder =
      dladdr(reinterpret_cast<void*>(&load_function), &here) != 0 ? fs::path(here.dli_fname).parent_path() : fs::path();
  const fs::path file = folder / (module + ".so");
  if (!fs::exists(file)) throw InputError("", without);
  void* const library = dlopen(file.c_str(), RTLD_NOW);
  void* const function = library ? dlsym(library, symbol) : nullptr;
  if (!function) throw std::runtime_error(dlerror());
  return function;
}

}  // namespace tanor::report
