#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/exit_code.hpp"
#include "picture/style.hpp"
#include "scene/overrides.hpp"

namespace tanor::cli {

/// Everything that a command line may say. A command reads what its arguments and options name.
struct Options {
  bool quiet = false;    ///< prints nothing but the result and what went wrong
  bool json = false;     ///< prints the result as JSON
  bool verbose = false;  ///< prints the identities of the certificate too, or in symbols
  std::filesystem::path scene;
  std::filesystem::path folder;              ///< of results that are shown
  std::optional<std::filesystem::path> out;  ///< folder or file of the results; default: the command's own
  scene::Overrides overrides;                ///< a step and tolerances exclude each other

  // Options of `run` follow.
  bool resume = false;
  bool overwrite = false;                  ///< replaces the same run if it lies there and is not at its end
  std::optional<double> checkpoint_every;  ///< s of the clock, at most, between two checkpoints; default 60
  bool report = false;                     ///< writes a page for a browser, report.html

  // Options of `forces` and `error-time` follow.
  std::filesystem::path motion;      ///< .csv or .npy, rows t, x1, y1, z1, x2, … or t, q1, q2, …
  std::vector<std::string> methods;  ///< that are compared; default: rattle, rk4, dopri5, dop853, taylor, auto
  std::optional<std::filesystem::path> reference;  ///< state at t_end that replaces the reference run

  // Options of `equilibrium` and `modes` follow.
  std::optional<std::size_t> num_modes;  ///< ModesOptions::all for all; default: none, or those of the scene
  bool pictures = false;                 ///< writes a picture of each mode, for ParaView

  // Options of `view` and `picture` follow.
  struct Server {
    int port = 0;  ///< on 127.0.0.1; 0 for any that is free
    bool no_open = false;
  } server;
  struct Instant {
    std::optional<double> time;  ///< s; default: the last frame
    int mode = 0;                ///< whose period is shown, from 1; 0: the motion
  } instant;
  picture::Style style;

  std::string topic;  ///< of `help` and `manual`: a command, or empty for all; of `completion`: a shell
};

/// A command such as "run", or "--version" or "--methods", and how it is to be done.
struct Request {
  std::string command;
  Options options;
};

/// Reads the command line. Throws InputError for wrong usage, with the option in its `where()` if there is one.
Request parse_command_line(int argc, const char* const* argv);

// There is one function for each command, in the file of its name.
ExitCode execute_run(const Options& options);
ExitCode execute_solve(const Options& options);
ExitCode execute_forces(const Options& options);
ExitCode execute_info(const Options& options);
ExitCode execute_check(const Options& options);
ExitCode execute_error_time(const Options& options);
ExitCode execute_equilibrium(const Options& options);
ExitCode execute_modes(const Options& options);
ExitCode execute_selftest(const Options& options);
ExitCode execute_view(const Options& options);
ExitCode execute_picture(const Options& options);
ExitCode execute_help(const Options& options);
ExitCode execute_manual(const Options& options);
ExitCode execute_completion(const Options& options);
ExitCode execute_version(const Options& options);
ExitCode execute_methods(const Options& options);

}  // namespace tanor::cli
