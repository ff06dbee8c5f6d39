#include "cli/interrupt.hpp"

#include <csignal>

namespace tanor::cli {

namespace {

volatile std::sig_atomic_t caught_signal = 0;

extern "C" void note_signal(int signal) {
  caught_signal = signal;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = note_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // the second signal finds the default; writes go on
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

const char* caught_interrupt() {
  if (caught_signal == 0) return nullptr;
  return caught_signal == SIGINT ? "SIGINT" : "SIGTERM";
}

}  // namespace tanor::cli
