/// Runs extreme scenes x methods and writes a page in Markdown: which survive, which are reported, which are lost.
///
///   extreme [seconds] [word]    time limit of a run (default 5); only scenes whose name holds the word, or of that
///   group
///
/// Each run is a process of its own: one that crashes or hangs is a row as well. Its time is that of the processor, so
/// that a busy machine makes no run slow.

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "motion/extreme_scenes.hpp"
#include "motion/extreme_sides.hpp"

namespace {

using namespace tanor;
using extreme::Case;

std::vector<Method> list_methods() {
  std::vector<Method> result;
  for (const MethodTraits& each : methods()) {
    if (each.method != Method::Auto) result.push_back(each.method);
  }
  return result;
}
const std::vector<Method> all_methods = list_methods();
constexpr double largest_drift = 1e-2;

struct Row {
  std::string verdict;           ///< "ok", "reported", "slow", "lost"
  double error = NAN;            ///< relative; NaN: nothing to compare with
  double drift = NAN;            ///< of energy, relative
  double violation = NAN;        ///< of positions, relative …
  double largest_violation = 0;  ///< … and what it may be: max(1e-12, 8 eps |r|/L)
  double seconds = 0.0;
  std::size_t steps = 0;
  std::string reason;
};

Row run(const Case& scene, Method method, double time_limit) {
  Row row;
  row.largest_violation = extreme::largest_violation(scene.system);
  const std::clock_t begin = std::clock();
  const auto elapsed = [&] { return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC; };
  try {
    Simulation simulation(scene.system, extreme::options_of(scene, method), {.threads = 1});
    const Outcome outcome =
        simulation.advance_to(scene.t_end, [&](const MotionReport&) { return elapsed() < time_limit; });
    row.seconds = elapsed();
    const MotionReport& report = simulation.report();
    row.steps = report.steps;
    row.drift = std::abs(report.energy.drift_relative());
    row.violation = report.violation.position;
    if (scene.error && simulation.time() == scene.t_end) row.error = scene.error(simulation);
    const bool finite = all_finite(simulation.positions()) && all_finite(simulation.velocities()) &&
                        all_finite(simulation.accelerations()) && all_finite(simulation.multipliers());
    row.verdict = outcome.ok() ? "ok" : "reported";
    row.reason = outcome.what;
    const auto lose = [&](const std::string& reason) {
      row.verdict = "lost";
      row.reason += (row.reason.empty() ? "" : "; ") + reason;
    };
    // A motion that reports its inaccuracy itself is not lost.
    const auto is_wrong = [&](const std::string& what) {
      if (report.accuracy_warning.empty()) return lose(what + ", not a word");
      if (row.verdict == "ok") row.verdict = "reported";
      row.reason = report.accuracy_warning;
    };
    if (!finite) lose("not finite");
    if (outcome.ok() && simulation.time() < scene.t_end) {
      row.verdict = "slow";
      row.reason = "at " + std::to_string(simulation.time() / scene.t_end * 100.0).substr(0, 5) + " % of the time";
    } else if (outcome.ok()) {
      // Where nothing moves the energy consists of rounding alone.
      const bool is_right = scene.error && row.error <= 1e-9;
      if (scene.error && !(row.error <= extreme::largest_error_of(scene, method))) is_wrong("wrong");
      if (!is_right && !(row.drift <= largest_drift)) is_wrong("energy drifts");
      if (!(row.violation <= row.largest_violation)) lose("rods are violated");
    }
  } catch (const InputError& error) {
    row.seconds = elapsed();
    row.verdict = "reported";
    row.reason = std::string("refused: ") + error.what();
  }
  return row;
}

/// Runs the scene in a process of its own.
Row run_guarded(const Case& scene, Method method, double usual_limit) {
  const double time_limit = usual_limit * scene.patience;
  int ends[2];
  if (pipe(ends) != 0) std::exit(1);
  const pid_t child = fork();
  if (child == 0) {
    alarm(static_cast<unsigned>(20 * time_limit) + 60);  // by the clock on the wall
    std::FILE* out = fdopen(ends[1], "w");
    const Row row = run(scene, method, time_limit);
    std::fprintf(out, "%.17g %.17g %.17g %.17g %.17g %zu %s|%s\n", row.error, row.drift, row.violation,
                 row.largest_violation, row.seconds, row.steps, row.verdict.c_str(), row.reason.c_str());
    std::fclose(out);
    _exit(0);
  }
  close(ends[1]);
  std::FILE* in = fdopen(ends[0], "r");
  std::array<char, 2000> text{};
  Row row;
  const bool answered = std::fgets(text.data(), text.size(), in) != nullptr;
  std::fclose(in);
  int status = 0;
  waitpid(child, &status, 0);
  if (!answered || !WIFEXITED(status)) {
    const int signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
    row.verdict = "lost";
    row.reason = signal == SIGALRM ? "hangs" : "crashed, signal " + std::to_string(signal);
    return row;
  }
  int used = 0;
  std::sscanf(text.data(), "%lg %lg %lg %lg %lg %zu %n", &row.error, &row.drift, &row.violation, &row.largest_violation,
              &row.seconds, &row.steps, &used);
  const std::string words = text.data() + used;
  const std::size_t bar = words.find('|');
  row.verdict = words.substr(0, bar);
  row.reason = words.substr(bar + 1, words.find('\n') - bar - 1);
  return row;
}

std::string brief(double x) {
  if (std::isnan(x)) return "";
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), x == 0.0 ? "0" : "%.0e", x);
  return text.data();
}

}  // namespace

int main(int argc, char** argv) {
  const double time_limit = argc > 1 ? std::atof(argv[1]) : 5.0;
  const std::string word = argc > 2 ? argv[2] : "";
  std::string matrix = "| scene |", rule = "|---|", details, lost;
  for (const Method method : all_methods) {
    matrix += " " + std::string(name_of(method)) + " |";
    rule += "---|";
  }
  matrix += "\n" + rule + "\n";
  std::map<std::string, int> counts;
  std::vector<Case> all = extreme::list_cases();
  std::ranges::move(extreme::list_one_sided_cases(), std::back_inserter(all));
  for (const Case& scene : all) {
    if (scene.name.find(word) == std::string::npos && scene.group != word) continue;
    matrix += "| " + scene.name + " |";
    for (const Method method : all_methods) {
      if (!scene.methods.empty() && std::ranges::find(scene.methods, method) == scene.methods.end()) {
        matrix += " |";
        continue;
      }
      const Row row = run_guarded(scene, method, time_limit);
      ++counts[row.verdict];
      const std::string measure = std::isnan(row.error) ? "(" + brief(row.drift) + ")" : brief(row.error);
      matrix += " " + (row.verdict == "ok" ? measure : row.verdict == "lost" ? "**lost**" : row.verdict) + " |";
      const std::string line = "| " + scene.name + " | " + std::string(name_of(method)) + " | " + row.verdict + " | " +
                               brief(row.error) + " | " + brief(row.drift) + " | " + brief(row.violation) + " / " +
                               brief(row.largest_violation) + " | " + std::to_string(row.steps) + " | " +
                               brief(row.seconds) + " | " + row.reason + " |\n";
      details += line;
      if (row.verdict == "lost") lost += line;
      std::fprintf(stderr, "%-50s %-18s %-9s error %-6s drift %-6s violation %-6s %8zu steps %6.2f s  %s\n",
                   scene.name.c_str(), std::string(name_of(method)).c_str(), row.verdict.c_str(),
                   brief(row.error).c_str(), brief(row.drift).c_str(), brief(row.violation).c_str(), row.steps,
                   row.seconds, row.reason.c_str());
    }
    matrix += "\n";
  }
  constexpr const char* head =
      "| scene | method | verdict | error | drift | violation / allowed | steps | s | reason |\n"
      "|---|---|---|---|---|---|---|---|---|\n";
  std::printf(
      "# Extreme scenes\n\n"
      "Written by `scripts/extreme` (`bench/extreme.cpp`, `tests/motion/extreme_scenes.hpp` and "
      "`tests/motion/extreme_sides.hpp` say what each scene is). "
      "%d runs survive, %d are reported with place and reason, %d are slow, %d are lost.\n\n"
      "A number: relative error against a closed form; in parentheses: drift of the energy, where there is none. "
      "Methods with tolerances: rtol 1e-10, the others take the steps that `extreme_scenes.hpp` gives them. "
      "*reported*: ended by itself with place and reason, or wrong and doubted by the run itself (`accuracy_warning`). "
      "*slow*: not at its end after %.0f s of the processor (more for the long and the large). "
      "**lost**: crashes, hangs, holds a number that is not finite, breaks constraints by more than "
      "max(1e-12, 8 eps |r|/L), or is wrong without a word (beside the scene's closed form by more than "
      "`largest_error_of` derives from tolerance or step and the length of the run, or by 1e-2 of the energy)."
      "\n\n%s\n"
      "## What is lost\n\n%s%s\n## Every run\n\n%s%s",
      counts["ok"], counts["reported"], counts["slow"], counts["lost"], time_limit, matrix.c_str(), head, lost.c_str(),
      head, details.c_str());
  return 0;
}
