#pragma once

#include <cstdlib>
#include <string>

#include "cli/program.hpp"

namespace tanor::cli {

/// What a script of the shell left behind, in which `tanor` is the program; what hangs is killed after a minute (137).
inline Ended run_script(const Folder& folder, const std::string& script) {
  static int count = 0;
  const std::string stem = (std::filesystem::temp_directory_path() / "tanor_script_").string() +
                           std::to_string(getpid()) + "_" + std::to_string(count++);
  write_text(stem, "cd '" + folder.path().string() + "'\ntanor() { \"" + TANOR_PROGRAM + "\" \"$@\"; }\n" + script);
  const int status =
      std::system(("timeout -s KILL 60 sh " + stem + " >" + stem + ".out 2>" + stem + ".err </dev/null").c_str());
  Ended ended;
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  ended.out = read_text(stem + ".out");
  ended.err = read_text(stem + ".err");
  for (const char* end : {"", ".out", ".err"}) std::filesystem::remove(stem + end);
  return ended;
}

/// Sanitizers map terabytes of addresses.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool limits_of_memory_work = false;
#else
constexpr bool limits_of_memory_work = true;
#endif

}  // namespace tanor::cli
