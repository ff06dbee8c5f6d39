#pragma once

#include <filesystem>
#include <string>

namespace tanor::cli {

/// While it lives no other process of the same command writes into the folder.
///
/// The lock is an flock on `<folder>/.<command>.lock`, which holds the number of its process; it ends with the process,
/// however that ends. The file goes with the lock.
class FolderLock {
 public:
  /// The folder is there. Throws InputError that names the process which holds it, WriteError where no file can be
  /// made.
  FolderLock(const std::filesystem::path& folder, const std::string& command);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

}  // namespace tanor::cli
