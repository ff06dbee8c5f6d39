#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/known_problems.hpp"
#include "cli/messages.hpp"
#include "report/digits.hpp"

namespace tanor::cli {

namespace {

report::DigitsRow solve(const KnownProblem& problem) {
  report::DigitsRow row{problem.name, problem.known, problem.method, problem.promised};
  const auto begin = std::chrono::steady_clock::now();
  const Finding finding = problem.solve();
  row.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  row.error = finding.error;
  row.outcome = finding.outcome;
  return row;
}

}  // namespace

ExitCode execute_selftest(const Options& options) {
  std::vector<report::DigitsRow> rows;
  for (const auto& list : {list_known_motions, list_known_mechanisms, list_known_friction, list_known_forces}) {
    for (const KnownProblem& problem : list()) rows.push_back(solve(problem));
  }
  options.json ? print_json(report::describe_digits(rows)) : print_lines(report::format_digits(rows));
  const Outcome outcome = report::verify_digits(rows);
  if (outcome.ok()) return ExitCode::Done;
  print_message("selftest: " + outcome.what, Tone::Error);
  return ExitCode::NoAnswer;
}

}  // namespace tanor::cli
