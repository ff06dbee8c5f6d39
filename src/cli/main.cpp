#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <exception>
#include <string>
#include <system_error>
#include <variant>

#include "cli/command_line.hpp"
#include "cli/messages.hpp"

namespace tanor::cli {

namespace {

/// Handles an exception that nobody catches, for instance in a thread of a library.
[[noreturn]] void end_with_last_words() {
  const Failure failure =
      std::current_exception() ? describe_current_exception() : Failure{ExitCode::MachineFailure, "ended by a library"};
  print_message(failure.message, Tone::Error);
  _exit(static_cast<int>(ExitCode::MachineFailure));
}

/// Executes what the command line asks for. Any trouble is one line on stderr.
ExitCode run_command(int argc, const char* const* argv) {
  try {
    return std::visit([](const auto& request) { return execute(request); }, parse_command_line(argc, argv));
  } catch (...) {
    const Failure failure = describe_current_exception();
    print_message(failure.message, Tone::Error);
    return failure.code;
  }
}

/// Closes standard output, which is complete only when the system has taken its last byte. Returns false if that
/// failed.
bool close_output() {
  const bool had_error = std::ferror(stdout) != 0;
  errno = 0;
  if (std::fflush(stdout) == 0 && !had_error) return true;
  const std::string reason = errno != 0 ? ": " + std::generic_category().message(errno) : "";
  print_message("cannot write standard output" + reason, Tone::Error);
  return false;
}

}  // namespace

}  // namespace tanor::cli

/// Runs the `tanor` program: scene files in, reports out. It is called by the launcher, which has loaded it.
extern "C" __attribute__((visibility("default"))) int tanor_run_program(int argc, char** argv) {
  using namespace tanor::cli;
  std::set_terminate(end_with_last_words);
  const ExitCode code = run_command(argc, argv);
  const bool has_failed = code == ExitCode::MachineFailure || !close_output();
  return static_cast<int>(has_failed ? ExitCode::MachineFailure : code);
}
