#pragma once

namespace tanor::cli {

/// From now on the first SIGINT or SIGTERM is only noted; the second one ends the program at once.
void catch_interrupts();

/// "SIGINT", "SIGTERM", or null while none has come.
const char* caught_interrupt();

}  // namespace tanor::cli
