#include "cli/process.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <initializer_list>
#include <latch>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include <tanor/build_info.hpp>

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

namespace {

/// Returns a function of a library that may be loaded in this process, or null.
template <class Function>
Function* find_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

void require_threads(int count) {
  const int others = (count > 0 ? count : count_threads()) - 1;
  std::latch all_are_here(1);
  std::vector<std::thread> threads;
  threads.reserve(static_cast<std::size_t>(std::max(others, 0)));
  std::string failure;
  try {
    for (int k = 0; k < others; ++k) threads.emplace_back([&] { all_are_here.wait(); });
  } catch (const std::exception& error) {
    failure = "cannot start " + std::to_string(others + 1) + " threads: " + error.what();
  }
  all_are_here.count_down();
  for (std::thread& thread : threads) thread.join();
  if (!failure.empty()) throw std::runtime_error(failure);
}

void require_work_space_of_blas() {
  if (!build_info().has_suitesparse_qr) return;
  if (auto* set_threads = find_function<void(int)>("openblas_set_num_threads")) set_threads(1);
  constexpr std::size_t bytes = std::size_t{160} << 20;  // OpenBLAS maps 128 MiB
  void* const room = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) throw std::runtime_error("out of memory: none is left for the work space of BLAS");
  munmap(room, bytes);
  const int one = 1;
  const double number = 1.0;
  double square = 0.0;
  using Square = void(const char*, const char*, const int*, const int*, const double*, const double*, const int*,
                      const double*, double*, const int*);
  if (auto* add_square = find_function<Square>("dsyrk_"))
    add_square("U", "N", &one, &one, &number, &number, &one, &number, &square, &one);
}

int count_threads() {
  if (auto* get_max_threads = find_function<int()>("omp_get_max_threads")) return get_max_threads();
  return static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

namespace {

constexpr Interrupt interrupts[] = {{SIGINT, "SIGINT", ExitCode::Interrupted},
                                    {SIGTERM, "SIGTERM", ExitCode::Terminated},
                                    {SIGHUP, "SIGHUP", ExitCode::HungUp}};

volatile std::sig_atomic_t caught_signal = 0;

extern "C" void note_signal(int signal) {
  caught_signal = signal;
}

}  // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = note_signal;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);  // a second signal finds the default; writes go on
  for (const Interrupt& each : interrupts) {
    struct sigaction before = {};
    sigaction(each.signal, nullptr, &before);
    if (before.sa_handler != SIG_IGN) sigaction(each.signal, &action, nullptr);
  }
}

std::optional<Interrupt> caught_interrupt() {
  for (const Interrupt& each : interrupts)
    if (each.signal == caught_signal) return each;
  return std::nullopt;
}

}  // namespace tanor::cli
