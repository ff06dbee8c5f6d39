#pragma once

#include <filesystem>
#include <string>

namespace tanor::cli {

/// Keeps other processes of the same command out of a folder while it lives.
///
/// The lock is an flock on `<folder>/.<command>.lock`, a file that holds the number of its process. It ends with the
/// process, however that ends, and the file goes with it.
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

/// Whether some process holds the lock of a command on a folder.
bool is_locked(const std::filesystem::path& folder, const std::string& command);

}  // namespace tanor::cli
