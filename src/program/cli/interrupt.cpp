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
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // a second signal finds the default; writes go on
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before = {};
    sigaction(signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
}

std::optional<Interrupt> caught_interrupt() {
  switch (caught_signal) {
    case SIGINT:
      return Interrupt{"SIGINT", ExitCode::Interrupted};
    case SIGTERM:
      return Interrupt{"SIGTERM", ExitCode::Terminated};
    case SIGHUP:
      return Interrupt{"SIGHUP", ExitCode::HungUp};
    default:
      return std::nullopt;
  }
}

}  // namespace tanor::cli
