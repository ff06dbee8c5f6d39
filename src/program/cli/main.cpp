#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <exception>
#include <string>
#include <string_view>
#include <system_error>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/process.hpp"

namespace tanor::cli {

namespace {

/// Handles an exception that nobody catches, for instance in a thread of a library.
[[noreturn]] void end_with_last_words() {
  const Failure failure =
      std::current_exception() ? describe_current_exception() : Failure{ExitCode::MachineFailure, "ended by a library"};
  print_message(failure.message, Tone::Error);
  _exit(static_cast<int>(ExitCode::MachineFailure));
}

/// Returns true if standard output failed because it is a pipe from which nobody reads any more.
bool is_unread() {
  pollfd output{.fd = STDOUT_FILENO, .events = 0, .revents = 0};
  return std::ferror(stdout) != 0 && poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
}

struct Execution {
  std::string_view command;
  ExitCode (*execute)(const Options&);
};
constexpr std::array<Execution, 16> commands{{{"run", execute_run},
                                              {"view", execute_view},
                                              {"picture", execute_picture},
                                              {"info", execute_info},
                                              {"check", execute_check},
                                              {"solve", execute_solve},
                                              {"forces", execute_forces},
                                              {"error-time", execute_error_time},
                                              {"equilibrium", execute_equilibrium},
                                              {"modes", execute_modes},
                                              {"selftest", execute_selftest},
                                              {"help", execute_help},
                                              {"completion", execute_completion},
                                              {"manual", execute_manual},
                                              {"--version", execute_version},
                                              {"--methods", execute_methods}}};

/// Executes what the command line asks for. Any trouble is one line on stderr.
ExitCode run_command(int argc, const char* const* argv) {
  try {
    const Request request = parse_command_line(argc, argv);
    return std::ranges::find(commands, request.command, &Execution::command)->execute(request.options);
  } catch (...) {
    const Failure failure = describe_current_exception();
    if (failure.code == ExitCode::MachineFailure && is_unread()) return ExitCode::Unread;
    print_message(failure.message, Tone::Error);
    return failure.code;
  }
}

/// Closes standard output, which is complete only when the system has taken its last byte. Returns the exit code.
ExitCode close_output(ExitCode code) {
  const bool had_error = std::ferror(stdout) != 0;
  errno = 0;
  if (std::fflush(stdout) == 0 && !had_error) return code;
  const std::string reason = errno != 0 ? ": " + std::generic_category().message(errno) : "";
  if (is_unread()) return ExitCode::Unread;
  print_message("cannot write standard output" + reason, Tone::Error);
  return ExitCode::MachineFailure;
}

/// Runs what the command line asks for and returns the exit code.
ExitCode answer(int argc, const char* const* argv) {
  const ExitCode code = run_command(argc, argv);
  const bool is_told = code == ExitCode::MachineFailure || code == ExitCode::Unread;
  return is_told ? code : close_output(code);
}

}  // namespace

}  // namespace tanor::cli

/// The `tanor` program: scene files in, reports out.
int main(int argc, char** argv) {
  using namespace tanor::cli;
  prepare_process(argv);
  std::set_terminate(end_with_last_words);
  try {
    const ExitCode code = answer(argc, argv);
    mark_as_answered();
    return static_cast<int>(code);
  } catch (...) {
    give_up("out of memory");
  }
}
