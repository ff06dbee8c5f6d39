#pragma once

namespace tanor::cli {

/// What the program tells its caller.
enum class ExitCode {
  Done = 0,
  BadInput = 2,       ///< or wrong usage
  NoAnswer = 3,       ///< numerical outcome: no answer, several (friction), tolerance not reached, stopped early
  MachineFailure = 4  ///< memory, disk, or our own bug
};

}  // namespace tanor::cli
