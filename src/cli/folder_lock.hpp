#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tanor::cli {

/// Keeps other processes that write results out of a folder while it lives.
///
/// The lock is an flock on `<folder>/.tanor.lock`, a file that holds the number of its process and the command. It ends
/// with the process, however that ends, and the file goes with it.
class FolderLock {
 public:
  /// The folder is there. Throws InputError that names the process which holds it, WriteError where no file can be
  /// made.
  FolderLock(const std::filesystem::path& folder, const std::string& command);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// The folder of that name is still the one that was locked.
  bool is_in_place() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// The command of the process that holds a folder; none: it is free.
std::optional<std::string> find_holder(const std::filesystem::path& folder);
/// For those who write a file there and hold nothing. Throws as FolderLock does where another process holds the folder.
void require_free(const std::filesystem::path& folder);

}  // namespace tanor::cli
