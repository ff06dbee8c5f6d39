#pragma once

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "report/reading.hpp"

namespace tanor::cli {

using report::list_names;
using report::read_json;
using report::read_text;
using report::write_text;
using Words = std::vector<std::string>;

/// Returns how often a text holds a part.
inline std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

/// The result of a run of the program.
struct Ended {
  int code = -1;  ///< exit code, or 128 + signal of a killed process
  std::string out, err;
};

/// The real program, working in a folder of the test. It does not outlive the test, however that ends.
class Program {
 public:
  /// `out` takes its standard output. If `out` is empty, Ended has it.
  Program(const Folder& folder, const Words& arguments, const std::string& out = "")
      : out_(out.empty() ? texts_ / "out" : std::filesystem::path(out)), process_(fork()) {
    if (process_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (process_ == 0) start(folder, arguments);
  }
  ~Program() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  pid_t process() const { return process_; }

  /// Waits for its end. `usage` gets the resources that it used.
  Ended wait(rusage* usage = nullptr) {
    int status = 0;
    wait4(process_, &status, 0, usage);
    process_ = -1;
    return {.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            .out = out_.parent_path() == texts_.path() ? read_text(out_) : "",
            .err = read_text(texts_ / "err")};
  }

 private:
  [[noreturn]] void start(const Folder& folder, const Words& arguments) const {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    dup2(open(out_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDOUT_FILENO);
    dup2(open((texts_ / "err").c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600), STDERR_FILENO);
    std::vector<char*> words{const_cast<char*>(TANOR_PROGRAM)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    if (chdir(folder.path().c_str()) == 0) execv(TANOR_PROGRAM, words.data());
    _exit(127);
  }

  Folder texts_;
  std::filesystem::path out_;
  pid_t process_;
};

inline Ended run_program(const Folder& folder, const Words& arguments) {
  return Program(folder, arguments).wait();
}

/// Returns the complaint of a program that must only complain, with one line, nothing on stdout and nothing written.
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

/// Waits for something that another process does. Returns false after a minute.
inline bool wait_until(const std::function<bool()>& is_done) {
  for (int k = 0; k < 6'000; ++k) {
    if (is_done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Returns how many frames a run has written.
inline std::size_t count_frames(const std::filesystem::path& out) {
  const std::filesystem::path frames = out / "trajectory";
  return std::filesystem::exists(frames) ? list_names(frames).size() : 0;
}
inline bool wait_for_frames(const std::filesystem::path& out, std::size_t count) {
  return wait_until([&] { return count_frames(out) >= count; });
}

/// A motion with 129 frames.
inline const std::string many_frames = R"("t_end": 1, "output_every": 0.0078125, "method": "rk4", "step": 0.0078125)";

/// Returns two beads that hang on a fixed point, released horizontally. `motion` are the members of "motion".
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

/// Returns a bead on two rods whose supports move apart. After 1 s the rods are straight, and no motion satisfies them
/// longer.
///
///     X->    <-- 2 m + 0.2 t^2 -->   <-X
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

/// Searches the equilibrium of a scene; results go to the folder at_rest.
inline Ended find_at_rest(const Folder& folder, const nlohmann::json& scene) {
  write_text(folder / "s.json", scene.dump());
  return run_program(folder, {"equilibrium", "s.json", "--out", "at_rest"});
}

/// Returns a bead that is to be on two spheres which do not meet, so that there is no start.
inline std::string torn_apart() {
  return R"({
    "tanor_scene": 1, "name": "torn apart", "points": {"positions": [[0,0,0]]},
    "constraints": [{"name": "left", "kind": "sphere", "points": [0], "center": [-3,0.1,0], "radius": 1},
                    {"name": "right", "kind": "sphere", "points": [0], "center": [3,0,0.2], "radius": 1}],
    "motion": {"t_end": 1, "start": "project"}})";
}

}  // namespace tanor::cli
