#pragma once

#include <cstdlib>
#include <string>

#include "cli/program.hpp"

namespace tanor::cli {

/// Runs a shell script in which `tanor` is the program and $TANOR its file. A script that hangs is killed after five
/// minutes (137).
inline Ended run_script(const Folder& folder, const std::string& script) {
  const Folder texts;
  const std::string stem = (texts / "script").string();
  write_text(stem, "cd '" + folder.path().string() + "'\nTANOR='" TANOR_PROGRAM "'\ntanor() { \"$TANOR\" \"$@\"; }\n" +
                       script);
  const int status =
      std::system(("timeout -s KILL 300 sh " + stem + " >" + stem + ".out 2>" + stem + ".err </dev/null").c_str());
  return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
          .out = read_text(stem + ".out"),
          .err = read_text(stem + ".err")};
}

/// True if limits of a process's memory are those of the program. Sanitizers map terabytes of addresses.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define TANOR_LIMITS_OF_MEMORY_WORK 0
#else
#define TANOR_LIMITS_OF_MEMORY_WORK 1
#endif

}  // namespace tanor::cli
