#pragma once

#include <optional>

#include "cli/exit_code.hpp"

namespace tanor::cli {

/// Catches signals: the first SIGINT, SIGTERM or SIGHUP is only noted, the second one of its kind ends the program at
/// once. A signal that was ignored when the program started (nohup) stays ignored.
void catch_interrupts();

/// A signal that came.
struct Interrupt {
  const char* name;
  ExitCode code;
};
std::optional<Interrupt> caught_interrupt();

}  // namespace tanor::cli
