#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace tanor::cli {

/// Keeps other processes that write results out of a folder while it lives.
///
/// The lock is an flock on `<folder>/.tanor.lock`, a file that holds the number of the process and the command. The
/// lock ends with the process, however that ends; the destructor also removes the file.
class FolderLock {
 public:
  /// Locks a folder that exists. Throws InputError that names the process which holds the folder, and WriteError if no
  /// file can be made.
  FolderLock(const std::filesystem::path& folder, const std::string& command);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// True if the folder of that name is still the one that was locked.
  bool is_in_place() const;

 private:
  std::filesystem::path file_;
  int descriptor_ = -1;
};

/// Returns the command of the process that holds a folder, or none if the folder is free.
std::optional<std::string> find_holder(const std::filesystem::path& folder);
/// Checks a folder for those who write a file there without holding it. Throws as FolderLock does if another process
/// holds the folder.
void require_free(const std::filesystem::path& folder);

}  // namespace tanor::cli
