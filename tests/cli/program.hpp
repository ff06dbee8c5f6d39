#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "report/reading.hpp"

namespace tanor::cli {

using report::Folder;
using report::list_names;
using report::read_json;
using report::read_text;
using report::write_text;
using Words = std::vector<std::string>;

/// What a run of the program left behind.
struct Ended {
  int code = -1;  ///< exit code; 128 + signal where one killed it
  std::string out, err;
};

/// The real program, working in a folder of the test.
class Program {
 public:
  Program(const Folder& folder, const Words& arguments, const std::string& out = "") {
    static int count = 0;
    const std::string stem = (std::filesystem::temp_directory_path() / "tanor_cli_").string() +
                             std::to_string(getpid()) + "_" + std::to_string(count++);
    is_own_ = out.empty();
    out_ = is_own_ ? stem + ".out" : out;
    err_ = stem + ".err";
    process_ = fork();
    if (process_ == 0) start(folder, arguments);
  }

  pid_t process() const { return process_; }

  Ended wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    Ended ended;
    ended.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    ended.err = read_text(err_);
    std::filesystem::remove(err_);
    if (is_own_) {
      ended.out = read_text(out_);
      std::filesystem::remove(out_);
    }
    return ended;
  }

 private:
  [[noreturn]] void start(const Folder& folder, const Words& arguments) const {
    dup2(open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
    dup2(open(err_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
    std::vector<char*> words{const_cast<char*>(TANOR_PROGRAM)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (chdir(folder.path().c_str()) == 0) execv(TANOR_PROGRAM, words.data());
    _exit(127);
  }

  std::string out_, err_;
  bool is_own_ = true;
  pid_t process_ = -1;
};

inline Ended run_program(const Folder& folder, const Words& arguments) {
  return Program(folder, arguments).wait();
}

/// The complaint of a program that must not do more than complain: one line, nothing on stdout, nothing written.
inline std::string complaint(const Folder& folder, const Words& arguments, int code = 2) {
  const Words before = list_names(folder.path());
  const Ended ended = run_program(folder, arguments);
  EXPECT_EQ(ended.code, code) << ended.err;
  EXPECT_EQ(ended.out, "");
  EXPECT_EQ(list_names(folder.path()), before) << "nothing is written";
  EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
  EXPECT_TRUE(ended.err.starts_with("tanor: ")) << ended.err;
  return ended.err;
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// Waits for something that another process does; false after 20 s.
inline bool wait_until(const std::function<bool()>& is_done) {
  for (int k = 0; k < 2000; ++k) {
    if (is_done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Two beads hanging on a fixed point, released horizontally; `motion`: members of that name.
///
///     X--o--o
inline std::string pendulum(const std::string& motion) {
  return R"({
    "tanor_scene": 1, "name": "pendulum",
    "points": {"positions": [[0,0,0], [0.1,0,0], [0.2,0,0]], "masses": 0.1},
    "supports": [{"points": [0]}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2]]}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}],
    "motion": {)" +
         motion + "}}";
}

/// A bead on two rods whose supports move apart: after 1 s the rods are straight, and no motion satisfies them longer.
///
///     X->    <-- 2 m + 0.2 t  -->    <-X
///       \____1.1 m____o____1.1 m____/
inline std::string overstretched() {
  return R"({
    "tanor_scene": 1, "name": "overstretched",
    "points": {"positions": [[-1,0,0], [0,0,-0.45825756949558399], [1,0,0]]},
    "supports": [{"points": [0], "motion": {"formula": ["-0.1*t*t", "0", "0"]}},
                 {"points": [2], "motion": {"formula": ["0.1*t*t", "0", "0"]}}],
    "constraints": [{"name": "rods", "kind": "rod", "pairs": [[0,1], [1,2]], "length": 1.1},
                    {"name": "sheet", "kind": "plane", "points": [1], "normal": [0,1,0]}],
    "motion": {"t_end": 3, "output_every": 0.125}})";
}

/// A bead that is to be on two spheres which do not meet: there is no start.
inline std::string torn_apart() {
  return R"({
    "tanor_scene": 1, "name": "torn apart", "points": {"positions": [[0,0,0]]},
    "constraints": [{"name": "left", "kind": "sphere", "points": [0], "center": [-3,0.1,0], "radius": 1},
                    {"name": "right", "kind": "sphere", "points": [0], "center": [3,0,0.2], "radius": 1}],
    "motion": {"t_end": 1, "start": "project"}})";
}

}  // namespace tanor::cli
