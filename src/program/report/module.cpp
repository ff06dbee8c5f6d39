#include "report/module.hpp"

#include <dlfcn.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include <tanor/error.hpp>

namespace tanor::report {

namespace fs = std::filesystem;

void* load_function(const std::string& module, const char* symbol, const std::string& without) {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  fs::path file = folder / (module + ".so");
  if (!fs::exists(file)) file = folder / TANOR_MODULE_FOLDER / (module + ".so");
  if (!fs::exists(file)) throw InputError("", without);
  void* const library = dlopen(file.c_str(), RTLD_NOW);
  void* const function = library ? dlsym(library, symbol) : nullptr;
  if (!function) throw std::runtime_error(dlerror());
  return function;
}

}  // namespace tanor::report
