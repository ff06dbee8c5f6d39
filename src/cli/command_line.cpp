#include "cli/command_line.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cstdio>
#include <system_error>

#include <tanor/build_info.hpp>
#include <tanor/error.hpp>
#include <tanor/motion.hpp>

namespace tanor::cli {

namespace {

template <class Number>
std::optional<Number> read_number(const std::string& text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

// Rules for values: an empty answer is a yes.

std::string require_positive(const std::string& text) {
  const std::optional<double> number = read_number<double>(text);
  return number && *number > 0.0 && *number < HUGE_VAL ? "" : "must be a finite number > 0, not '" + text + "'";
}

std::string require_interval(const std::string& text) {
  constexpr double most = 1e9;  // what a clock can add
  const std::optional<double> number = read_number<double>(text);
  return number && *number >= 0.0 && *number <= most ? "" : "must be a number from 0 to 1e9, not '" + text + "'";
}

std::string require_threads(const std::string& text) {
  const std::optional<int> number = read_number<int>(text);
  const std::string range = "0 (= all) to " + std::to_string(scene::most_threads);
  return number && *number >= 0 && *number <= scene::most_threads
             ? ""
             : "must be a whole number " + range + ", not '" + text + "'";
}

std::string require_text(const std::string& text) {
  return text.empty() ? "must not be empty" : "";
}

void add_scene(CLI::App* command, std::filesystem::path* scene) {
  command->add_option("SCENE", *scene, "scene file (JSON)")->required();
}

/// Options of both commands that move a scene.
void add_motion(CLI::App* command, scene::Overrides* overrides) {
  command->add_option("--t-end", overrides->t_end, "end of the simulated time, s")->check(require_positive);
  command->add_option("--threads", overrides->threads, "threads; 0: all")->check(require_threads);
}

/// A line each: name, order, kind of steps, what it is.
std::string list_methods() {
  std::string text;
  for (const MethodTraits& each : methods()) {
    text +=
        fmt::format("{:20}{:8}{:10}{:10}{}\n", each.name, each.order > 0 ? fmt::format("{}", each.order) : "any",
                    each.has_fixed_steps ? "fixed" : "adaptive", each.is_implicit ? "implicit" : "explicit", each.what);
  }
  return text;
}

void add_run(CLI::App* app, RunOptions* options) {
  CLI::App* command = app->add_subcommand("run", "Simulate a scene and write its trajectory and summary");
  add_scene(command, &options->scene);
  command->add_option("--out", options->out, "folder of the results; default <name>.out")->check(require_text);
  scene::Overrides* over = &options->overrides;
  command->add_option("--method", over->method, "one of those that tanor --methods lists");
  CLI::Option* step =
      command->add_option("--step", over->step, "fixed step, or the first one to try with adaptive methods, s");
  CLI::Option* rtol = command->add_option("--rtol", over->rtol, "relative tolerance")->check(require_positive);
  CLI::Option* atol = command->add_option("--atol", over->atol, "absolute tolerance, m; default: 1e-10 of the size")
                          ->check(require_positive);
  step->check(require_positive)->excludes(rtol, atol);
  command->add_option("--max-step", over->max_step, "no step is longer, s")->check(require_positive);
  add_motion(command, over);
  command->add_flag("--resume", options->resume, "go on from the checkpoint of an interrupted run");
  command
      ->add_option("--checkpoint-every", options->checkpoint_every,
                   "also between frames, s of the clock; 0: as often as takes a twentieth of the time; default: 60")
      ->check(require_interval);
  command->add_flag("--quiet", options->quiet, "no progress on stderr");
  command->add_flag("--report", options->report, "write report.html too: the motion in 3-D, histories, certificate");
}

void add_solve(CLI::App* app, SolveOptions* options) {
  CLI::App* command = app->add_subcommand("solve", "Solve the dynamics once at t = 0");
  add_scene(command, &options->scene);
  command->add_option("--out", options->out, "JSON file; default standard output")->check(require_text);
}

void add_forces(CLI::App* app, ForcesOptions* options) {
  CLI::App* command = app->add_subcommand("forces", "Reactions and control forces of a given motion");
  add_scene(command, &options->scene);
  command->add_option("--motion", options->motion, ".csv or .npy, rows t, x1, y1, z1, x2, …")
      ->required()
      ->check(require_text);
  command->add_option("--out", options->out, "folder of the results; default <name>.out")->check(require_text);
}

void add_info(CLI::App* app, InfoOptions* options) {
  CLI::App* command = app->add_subcommand("info", "Tell what a scene needs and what a step will cost; solves nothing");
  add_scene(command, &options->scene);
}

void add_check(CLI::App* app, CheckOptions* options) {
  CLI::App* command = app->add_subcommand("check", "Consistency of the start, rank, redundant constraints, identities");
  add_scene(command, &options->scene);
}

void add_error_time(CLI::App* app, ErrorTimeOptions* options) {
  CLI::App* command = app->add_subcommand("error-time", "Error against run time: tables and plots");
  add_scene(command, &options->scene);
  command->add_option("--methods", options->methods, "default rattle rk4 dopri5 dop853 taylor auto (the scene's own)")
      ->delimiter(',');
  command->add_option("--out", options->out, "folder of tables and plots; default <name>.out")->check(require_text);
  command->add_option("--reference", options->reference, "file with the state at the end; default: another method")
      ->check(require_text);
  command->add_option("--step", options->overrides.step, "coarsest fixed step, s")->check(require_positive);
  add_motion(command, &options->overrides);
  command->add_flag("--quiet", options->quiet, "no progress on stderr");
}

void add_selftest(CLI::App* app) {
  app->add_subcommand("selftest", "Published and closed-form problems: digits won, in seconds");
}

}  // namespace

Command parse_command_line(int argc, const char* const* argv) {
  RunOptions run;
  SolveOptions solve;
  ForcesOptions forces;
  InfoOptions info;
  CheckOptions check;
  ErrorTimeOptions error_time;
  CLI::App app("Motion and reactions of large systems of material points under constraints.", "tanor");
  app.set_version_flag("--version", describe(build_info()));
  bool lists_methods = false;
  app.add_flag("--methods", lists_methods, "list the methods: name, order, steps, what it is");
  app.require_subcommand(0, 1);  // none is our complaint: CLI11 would not name an unknown one
  add_run(&app, &run);
  add_solve(&app, &solve);
  add_forces(&app, &forces);
  add_info(&app, &info);
  add_check(&app, &check);
  add_error_time(&app, &error_time);
  add_selftest(&app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return TextRequest{app.help()};
  } catch (const CLI::CallForVersion& version) {
    return TextRequest{version.what() + std::string("\n")};
  } catch (const CLI::ParseError& error) {
    throw InputError("", std::string(error.what()) + "; see tanor --help");
  }
  if (lists_methods) return TextRequest{list_methods()};
  if (app.get_subcommands().empty()) throw InputError("", "a subcommand is required; see tanor --help");
  if (app.got_subcommand("run")) return run;
  if (app.got_subcommand("solve")) return solve;
  if (app.got_subcommand("forces")) return forces;
  if (app.got_subcommand("check")) return check;
  if (app.got_subcommand("error-time")) return error_time;
  if (app.got_subcommand("selftest")) return SelftestOptions{};
  return info;
}

ExitCode execute(const TextRequest& request) {
  std::fputs(request.text.c_str(), stdout);
  return ExitCode::Done;
}

}  // namespace tanor::cli
