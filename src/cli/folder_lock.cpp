#include "cli/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "report/output_file.hpp"

namespace tanor::cli {

namespace {

/// Reads the number that the holder of the lock has written. It may not have written it yet.
std::string read_holder(int descriptor) {
  std::array<char, 32> bytes;
  const ssize_t size = pread(descriptor, bytes.data(), bytes.size(), 0);
  const std::string_view text(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0);
  return text.empty() ? "another process" : fmt::format("process {}", text.substr(0, text.find('\n')));
}

/// Whether the file is still the one of that name. Its last holder removes it.
bool is_named(int descriptor, const std::filesystem::path& path) {
  struct stat opened = {}, named = {};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

std::filesystem::path name_lock(const std::filesystem::path& folder, const std::string& command) {
  return folder / fmt::format(".{}.lock", command);
}

/// Takes a lock. Who looks whether there is one (`is_locked`) holds it for a moment, and is waited for.
bool take(int descriptor) {
  for (int tries = 0; flock(descriptor, LOCK_EX | LOCK_NB) != 0; ++tries) {
    // A file system that knows no locks gives none; the run is not refused for that.
    if (errno != EWOULDBLOCK) return true;
    if (tries == 10) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::string& command)
    : file_(name_lock(folder, command)) {
  while (true) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw report::WriteError(file_.string());
    if (!take(descriptor_)) {
      const std::string holder = read_holder(descriptor_);
      close(descriptor_);
      throw std::runtime_error(
          fmt::format("{}: is in use by {} (tanor {}); wait for it, or choose another folder "
                      "with --out",
                      folder.string(), holder, command));
    }
    if (is_named(descriptor_, file_)) break;
    close(descriptor_);
  }
  const std::string text = fmt::format("{}\n", getpid());
  // On a full disk the file stays empty: the lock holds, though it cannot name its process.
  [[maybe_unused]] const bool names_us =
      ftruncate(descriptor_, 0) == 0 && pwrite(descriptor_, text.data(), text.size(), 0) > 0;
}

FolderLock::~FolderLock() {
  if (is_in_place()) unlink(file_.c_str());
  close(descriptor_);
}

bool FolderLock::is_in_place() const {
  return is_named(descriptor_, file_);
}

bool is_locked(const std::filesystem::path& folder, const std::string& command) {
  const int descriptor = open(name_lock(folder, command).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool is_held = flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return is_held;
}

}  // namespace tanor::cli
