#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cli/exit_code.hpp"
#include "scene/overrides.hpp"

namespace tanor::cli {

/// `tanor run`
struct RunOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.out`
  scene::Overrides overrides;                ///< a step excludes tolerances
  bool resume = false;
  double checkpoint_every = 60.0;  ///< s of the clock, at most, between two checkpoints
  bool quiet = false;
  bool report = false;  ///< a page for a browser, report.html
};

/// `tanor solve`
struct SolveOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out;  ///< file; default: standard output
};

/// `tanor forces`
struct ForcesOptions {
  std::filesystem::path scene;
  std::filesystem::path motion;              ///< .csv or .npy, rows t, x1, y1, z1, x2, … or t, q1, q2, …
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.out`
};

/// `tanor info`
struct InfoOptions {
  std::filesystem::path scene;
};

/// `tanor check`: consistency of the start, rank, redundant constraints, conditioning, identities.
struct CheckOptions {
  std::filesystem::path scene;
};

/// `tanor error-time`: each method with four step sizes or tolerances against a finer run of another method.
struct ErrorTimeOptions {
  std::filesystem::path scene;
  std::vector<std::string> methods;                ///< default: rattle, rk4, dopri5, dop853, taylor, auto
  std::optional<std::filesystem::path> out;        ///< folder; default: `<name>.out`
  std::optional<std::filesystem::path> reference;  ///< state at t_end that replaces the reference run
  scene::Overrides overrides;                      ///< the coarsest step, t_end, threads
  bool quiet = false;
};

/// `tanor selftest`: problems with known answers, digits won.
struct SelftestOptions {};

/// A text that was asked for: --help, --version.
struct TextRequest {
  std::string text;
};

using Command = std::variant<RunOptions, SolveOptions, ForcesOptions, InfoOptions, CheckOptions, ErrorTimeOptions,
                             SelftestOptions, TextRequest>;

/// Reads the command line. Throws InputError for wrong usage, the option in its `where()` where there is one.
Command parse_command_line(int argc, const char* const* argv);

// One for each command, in the file of its name.
ExitCode execute(const RunOptions& options);
ExitCode execute(const SolveOptions& options);
ExitCode execute(const ForcesOptions& options);
ExitCode execute(const InfoOptions& options);
ExitCode execute(const CheckOptions& options);
ExitCode execute(const ErrorTimeOptions& options);
ExitCode execute(const SelftestOptions& options);
ExitCode execute(const TextRequest& request);

}  // namespace tanor::cli
