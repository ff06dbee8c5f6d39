#include "cli/process.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <initializer_list>

#include "cli/exit_code.hpp"

namespace tanor::cli {

namespace {

constexpr int machine_failure = static_cast<int>(ExitCode::MachineFailure);

bool is_limited(decltype(RLIMIT_AS) memory) {
  rlimit limit{};
  return getrlimit(memory, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY;
}

/// Starts the program again, with one thread of BLAS, where its memory is limited. OpenBLAS, which CHOLMOD is linked
/// to, maps 128 MiB for each further thread when it is loaded, and a thread that gets none asks for it forever.
void start_with_one_thread_of_blas(char** argv) {
  const char* const variable = "OPENBLAS_NUM_THREADS";
  if (std::getenv(variable) != nullptr || (!is_limited(RLIMIT_AS) && !is_limited(RLIMIT_DATA))) return;
  setenv(variable, "1", 1);
  execv("/proc/self/exe", argv);  // it returns where there is no /proc; then the threads stay
}

/// Occupies closed descriptors below 3. Such a descriptor would be given to the first file that is opened, and what is
/// printed would land in it. Each gets a stand-in on which printing fails as it does on the closed one.
void occupy_closed_descriptors() {
  for (int descriptor = 0; descriptor < 3; ++descriptor) {
    if (fcntl(descriptor, F_GETFD) != -1 || errno != EBADF) continue;
    // The lowest free number is this one.
    if (open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) _exit(machine_failure);
  }
}

/// Ignores the signals of a file that may not grow (ulimit -f) and of a reader that is gone. Writing then fails, which
/// is reported.
void turn_signals_into_failed_writes() {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
}

bool has_answered = false;

/// Handles a library that calls exit when it gives up, as libgomp does if it cannot start a thread. The exit code is
/// that of a machine failure.
void end_as_machine_failure() {
  if (has_answered) return;
  std::fflush(nullptr);
  _exit(machine_failure);
}

}  // namespace

void prepare_process(char** argv) {
  start_with_one_thread_of_blas(argv);
  occupy_closed_descriptors();
  turn_signals_into_failed_writes();
  std::atexit(end_as_machine_failure);
}

void give_up(const char* why) {
  for (const char* part : {"tanor: ", why, "\n"}) {
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  }
  _exit(machine_failure);
}

void mark_as_answered() {
  has_answered = true;
}

}  // namespace tanor::cli
