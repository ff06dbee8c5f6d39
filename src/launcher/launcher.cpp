#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string>

// The `tanor` executable. It needs only the C++ library, prepares the process, and only then loads the program with all
// its libraries. So whatever is missing then, also memory for the libraries themselves, is reported.

namespace {

namespace fs = std::filesystem;

constexpr int machine_failure = 4;  // cli/exit_code.hpp

/// Ends a process that cannot do more, with a message. Allocates nothing and touches no buffer.
[[noreturn]] void give_up(const char* why) {
  for (const char* part : {"tanor: ", why, "\n"}) {
    if (write(STDERR_FILENO, part, std::strlen(part)) < 0) break;
  }
  _exit(machine_failure);
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

/// Returns the program's file: beside this one (build tree), or where it was installed.
std::string find_program() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  const fs::path beside = folder / TANOR_PROGRAM_FILE;
  return fs::exists(beside, error) ? beside : folder / TANOR_PROGRAM_FOLDER / TANOR_PROGRAM_FILE;
}

using RunProgram = int(int, char**);

RunProgram* load_program() {
  // BLAS starts its threads when it is loaded. Our own loops use all processors, and a thread of BLAS that gets no
  // memory asks for it forever.
  setenv("OPENBLAS_NUM_THREADS", "1", 1);
  void* const program = dlopen(find_program().c_str(), RTLD_NOW | RTLD_GLOBAL);
  void* const function = program ? dlsym(program, "tanor_run_program") : nullptr;
  if (!function) give_up(dlerror());
  return reinterpret_cast<RunProgram*>(function);
}

}  // namespace

/// Replaces the C library's mmap for every library of the process. OpenBLAS maps its work space (128 MiB a thread)
/// inside the first call that needs it, has no way to report that it got none, and tries again forever; the program
/// ends here instead. All other callers get the failure as usual.
extern "C" __attribute__((visibility("default"))) void* mmap(void* address, std::size_t length, int protection,
                                                             int flags, int descriptor, off_t offset) {
  void* const memory =
      reinterpret_cast<void*>(syscall(SYS_mmap, address, length, protection, flags, descriptor, offset));
  if (memory != MAP_FAILED) return memory;
  const int reason = errno;
  Dl_info caller{};
  if (dladdr(__builtin_return_address(0), &caller) != 0 && caller.dli_fname && std::strstr(caller.dli_fname, "blas")) {
    give_up("out of memory: none is left for the work space of BLAS");
  }
  errno = reason;
  return MAP_FAILED;
}

int main(int argc, char** argv) {
  occupy_closed_descriptors();
  turn_signals_into_failed_writes();
  std::atexit(end_as_machine_failure);
  try {
    RunProgram* const run_program = load_program();
    const int code = run_program(argc, argv);
    has_answered = true;
    return code;
  } catch (...) {
    give_up("out of memory");
  }
}
