#pragma once

#include <fcntl.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "cli/program.hpp"

namespace tanor::cli {

struct Window {
  unsigned short columns = 80;
  std::map<std::string, std::string> environment{{"TERM", "xterm"}};
};

/// Runs the program on a terminal of its own, which has one stream for all, Ended::out. `type` gets what was shown so
/// far and returns what somebody then types.
inline Ended run_on_terminal(const Folder& folder, const Words& arguments, const Window& window = {},
                             const std::function<std::string(const std::string&)>& type = {}) {
  winsize size{.ws_row = 40, .ws_col = window.columns, .ws_xpixel = 0, .ws_ypixel = 0};
  int terminal = -1;
  const pid_t process = forkpty(&terminal, nullptr, nullptr, &size);
  if (process == 0) {
    for (const char* name : {"NO_COLOR", "TERM"}) unsetenv(name);
    for (const auto& [name, value] : window.environment) setenv(name.c_str(), value.c_str(), 1);
    std::vector<char*> words{const_cast<char*>(TANOR_PROGRAM)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (chdir(folder.path().c_str()) == 0) execv(TANOR_PROGRAM, words.data());
    _exit(127);
  }
  Ended ended;
  char bytes[4096];
  for (ssize_t taken = 0; (taken = read(terminal, bytes, sizeof bytes)) > 0 || (taken < 0 && errno == EINTR);) {
    if (taken < 0) continue;
    ended.out.append(bytes, static_cast<std::size_t>(taken));
    if (!type) continue;
    const std::string keys = type(ended.out);
    EXPECT_EQ(write(terminal, keys.data(), keys.size()), static_cast<ssize_t>(keys.size()));
  }
  int status = 0;
  waitpid(process, &status, 0);
  close(terminal);
  ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ended;
}

}  // namespace tanor::cli
