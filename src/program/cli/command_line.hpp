#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "cli/exit_code.hpp"
#include "picture/style.hpp"
#include "scene/overrides.hpp"

namespace tanor::cli {

/// Options that every command has.
struct CommonOptions {
  bool quiet = false;  ///< prints nothing but the result and what went wrong
  bool json = false;   ///< prints the result as JSON
};

/// `tanor run`
struct RunOptions : CommonOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.out`
  scene::Overrides overrides;                ///< a step and tolerances exclude each other
  bool resume = false;
  bool overwrite = false;                  ///< replaces the same run if it lies there and is not at its end
  std::optional<double> checkpoint_every;  ///< s of the clock, at most, between two checkpoints; default 60
  bool report = false;                     ///< writes a page for a browser, report.html
  bool verbose = false;                    ///< prints the identities of the certificate too
};

/// `tanor solve`
struct SolveOptions : CommonOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out;  ///< file; default: standard output
};

/// `tanor forces`
struct ForcesOptions : CommonOptions {
  std::filesystem::path scene;
  std::filesystem::path motion;              ///< .csv or .npy, rows t, x1, y1, z1, x2, … or t, q1, q2, …
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.out`
};

/// `tanor info`
struct InfoOptions : CommonOptions {
  std::filesystem::path scene;
};

/// `tanor check`: consistency of the start, rank, redundant constraints, conditioning, identities.
struct CheckOptions : CommonOptions {
  std::filesystem::path scene;
  bool verbose = false;  ///< prints the identities of the certificate in symbols
};

/// `tanor error-time`: compares each method at four step sizes or tolerances with a finer run of another method.
struct ErrorTimeOptions : CommonOptions {
  std::filesystem::path scene;
  std::vector<std::string> methods;                ///< default: rattle, rk4, dopri5, dop853, taylor, auto
  std::optional<std::filesystem::path> out;        ///< folder; default: `<name>.out`
  std::optional<std::filesystem::path> reference;  ///< state at t_end that replaces the reference run
  scene::Overrides overrides;                      ///< the coarsest step, t_end, threads
};

/// `tanor equilibrium`
struct EquilibriumCommand : CommonOptions {
  std::filesystem::path scene;
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.equilibrium.out`
  std::optional<std::size_t> modes;          ///< number of vibrations about the rest position; none if not asked for
};

/// `tanor modes`: small vibrations about the scene's positions.
struct ModesCommand : CommonOptions {
  std::filesystem::path scene;
  std::optional<std::size_t> count;          ///< replaces the scene's own; ModesOptions::all for all
  std::optional<std::filesystem::path> out;  ///< folder; default: `<name>.modes.out`
  bool pictures = false;                     ///< writes a picture of each mode, for ParaView
};

/// `tanor selftest`: solves problems with known answers and counts the correct digits.
struct SelftestOptions : CommonOptions {};

/// `tanor view`: the page of a run in a browser.
struct ViewOptions : CommonOptions {
  std::filesystem::path folder;
  int port = 0;  ///< on 127.0.0.1; 0 for any that is free
  bool no_open = false;
};

/// `tanor picture`: draws an instant of a run as PNG.
struct PictureOptions : CommonOptions {
  std::filesystem::path folder;
  std::optional<double> time;                ///< s; default: the last frame
  std::optional<std::filesystem::path> out;  ///< file; default: picture.png in the folder
  picture::Style style;
};

/// `tanor help`, `tanor manual`, `tanor completion`: print what the table of commands says.
struct HelpOptions : CommonOptions {
  std::string command;  ///< empty for all
};
struct ManualOptions : CommonOptions {
  std::string command;                       ///< empty for the program
  std::optional<std::filesystem::path> out;  ///< folder for all pages; default: one page on standard output
};
struct CompletionOptions : CommonOptions {
  std::string shell;
};

/// `tanor --version`, `tanor --methods`.
struct VersionOptions : CommonOptions {};
struct MethodsOptions : CommonOptions {};

/// The request of a command line.
using Request = std::variant<RunOptions, SolveOptions, ForcesOptions, InfoOptions, CheckOptions, ErrorTimeOptions,
                             EquilibriumCommand, ModesCommand, SelftestOptions, ViewOptions, PictureOptions,
                             HelpOptions, ManualOptions, CompletionOptions, VersionOptions, MethodsOptions>;

/// Reads the command line. Throws InputError for wrong usage, with the option in its `where()` if there is one.
Request parse_command_line(int argc, const char* const* argv);

// There is one function for each command, in the file of its name.
ExitCode execute(const RunOptions& options);
ExitCode execute(const SolveOptions& options);
ExitCode execute(const ForcesOptions& options);
ExitCode execute(const InfoOptions& options);
ExitCode execute(const CheckOptions& options);
ExitCode execute(const ErrorTimeOptions& options);
ExitCode execute(const EquilibriumCommand& command);
ExitCode execute(const ModesCommand& command);
ExitCode execute(const SelftestOptions& options);
ExitCode execute(const ViewOptions& options);
ExitCode execute(const PictureOptions& options);
ExitCode execute(const HelpOptions& options);
ExitCode execute(const ManualOptions& options);
ExitCode execute(const CompletionOptions& options);
ExitCode execute(const VersionOptions& options);
ExitCode execute(const MethodsOptions& options);

}  // namespace tanor::cli
