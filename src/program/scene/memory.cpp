#include "scene/memory.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>

namespace tanor::scene {

namespace {

namespace fs = std::filesystem;

/// Reads the number in a file; it is infinite if the file has none ("max").
double read_limit(const fs::path& file) {
  std::ifstream stream(file);
  double bytes = 0.0;
  return stream >> bytes ? bytes : std::numeric_limits<double>::infinity();
}

/// Returns the least limit of a control group and of the groups above it.
double read_limits(const fs::path& root, std::string group, const char* name) {
  double least = std::numeric_limits<double>::infinity();
  while (true) {
    least = std::min(least, read_limit(root / fs::path(group).relative_path() / name));
    if (group.empty() || group == "/") return least;
    group = fs::path(group).parent_path().string();
  }
}

/// Returns the limit of the process's control groups, from lines "0::/group" (version 2) and "5:memory:/group" (version
/// 1).
double measure_control_groups() {
  double least = std::numeric_limits<double>::infinity();
  std::ifstream lines("/proc/self/cgroup");
  for (std::string line; std::getline(lines, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1), group = line.substr(second + 1);
    if (controllers.empty()) least = std::min(least, read_limits("/sys/fs/cgroup", group, "memory.max"));
    if (controllers == "memory")
      least = std::min(least, read_limits("/sys/fs/cgroup/memory", group, "memory.limit_in_bytes"));
  }
  return least;
}

}  // namespace

double measure_memory() {
  double least = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
  rlimit addresses{};
  if (getrlimit(RLIMIT_AS, &addresses) == 0 && addresses.rlim_cur != RLIM_INFINITY)
    least = std::min(least, static_cast<double>(addresses.rlim_cur));
  return std::min(least, measure_control_groups());
}

}  // namespace tanor::scene
