#include "cli/folder_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <sstream>
#include <stdexcept>
#include <thread>

#include "report/output_file.hpp"

namespace tanor::cli {

namespace {

/// The holder of a lock, such as "1234" and "run". Both are empty while they are not written yet.
struct Holder {
  std::string process, command;
};

Holder read_holder(int descriptor) {
  std::array<char, 64> bytes;
  const ssize_t size = pread(descriptor, bytes.data(), bytes.size(), 0);
  std::istringstream text(std::string(bytes.data(), size > 0 ? static_cast<std::size_t>(size) : 0));
  Holder holder;
  text >> holder.process >> holder.command;
  return holder;
}

[[noreturn]] void refuse(const std::filesystem::path& folder, const Holder& holder) {
  const std::string who =
      holder.command.empty() ? "another process" : fmt::format("process {} (tanor {})", holder.process, holder.command);
  throw std::runtime_error(
      fmt::format("{}: is in use by {}; wait for it, or choose another folder with --out", folder.string(), who));
}

/// True if the file is still the one of that name. Its last holder removes it.
bool is_named(int descriptor, const std::filesystem::path& path) {
  struct stat opened = {}, named = {};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

constexpr const char* lock_name = ".tanor.lock";

/// Takes a lock. A process that only looks whether there is one holds it for a moment, so this function waits.
bool take(int descriptor) {
  for (int tries = 0; flock(descriptor, LOCK_EX | LOCK_NB) != 0; ++tries) {
    // A file system without locks gives none; the run is not refused for that.
    if (errno != EWOULDBLOCK) return true;
    if (tries == 10) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

std::optional<Holder> look(const std::filesystem::path& folder) {
  const int descriptor = open((folder / lock_name).c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return {};
  std::optional<Holder> holder;
  if (flock(descriptor, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK) holder = read_holder(descriptor);
  close(descriptor);
  return holder;
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder, const std::string& command) : file_(folder / lock_name) {
  while (true) {
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw report::WriteError(file_.string());
    if (!take(descriptor_)) {
      const Holder holder = read_holder(descriptor_);
      close(descriptor_);
      refuse(folder, holder);
    }
    if (is_named(descriptor_, file_)) break;
    close(descriptor_);
  }
  const std::string text = fmt::format("{} {}\n", getpid(), command);
  // On a full disk the file stays empty; the lock holds, though it cannot name its process.
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

std::optional<std::string> find_holder(const std::filesystem::path& folder) {
  const std::optional<Holder> holder = look(folder);
  return holder ? std::optional(holder->command) : std::nullopt;
}

void require_free(const std::filesystem::path& folder) {
  if (const std::optional<Holder> holder = look(folder)) refuse(folder, *holder);
}

}  // namespace tanor::cli
