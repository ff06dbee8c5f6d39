#pragma once

#include <optional>

#include "cli/exit_code.hpp"

namespace tanor::cli {

/// Makes the process fit for work. This must be the first call of the program; `argv` are its arguments.
void prepare_process(char** argv);

/// Ends a process that cannot do more, with a message. Allocates nothing and touches no buffer.
[[noreturn]] void give_up(const char* why);

/// Marks that the program ends by itself, with an exit code of its own.
void mark_as_answered();

/// Throws std::runtime_error if the machine does not give that many threads (0: as many as OpenMP wants), since OpenMP
/// would end the program without a word of ours.
void require_threads(int count);

/// Makes the first call of BLAS, if SuiteSparseQR is to call it, with one thread. OpenBLAS maps its work space (128
/// MiB) in that call, keeps it, and asks for it forever if the system refuses it. Throws std::runtime_error where it
/// would.
void require_work_space_of_blas();

/// Returns the number of threads that OpenMP gives a parallel loop.
int count_threads();

/// Catches signals: the first SIGINT, SIGTERM or SIGHUP is only noted, the second one of its kind ends the program at
/// once. A signal that was ignored when the program started (nohup) stays ignored.
void catch_interrupts();

/// A signal that came.
struct Interrupt {
  int signal;
  const char* name;
  ExitCode code;
};
std::optional<Interrupt> caught_interrupt();

}  // namespace tanor::cli
