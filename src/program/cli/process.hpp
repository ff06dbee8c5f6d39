#pragma once

namespace tanor::cli {

/// Makes the process fit for work. This must be the first call of the program; `argv` are its arguments.
void prepare_process(char** argv);

/// Ends a process that cannot do more, with a message. Allocates nothing and touches no buffer.
[[noreturn]] void give_up(const char* why);

/// Marks that the program ends by itself, with an exit code of its own.
void mark_as_answered();

}  // namespace tanor::cli
