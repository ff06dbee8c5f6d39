#pragma once

namespace tanor::cli {

/// Exit codes of the program.
enum class ExitCode {
  Done = 0,
  BadInput = 2,        ///< or wrong usage
  NoAnswer = 3,        ///< numerical outcome: no answer, several (friction), tolerance not reached, stopped early
  MachineFailure = 4,  ///< memory, disk, or our own bug
  // 128 + signal, as shells report it; what was found until then is complete and can be resumed.
  HungUp = 129,
  Interrupted = 130,
  Unread = 141,  ///< SIGPIPE: the reader of standard output is gone, as `| head` goes; nothing is said
  Terminated = 143
};

}  // namespace tanor::cli
