#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tanor::report {

/// A file to whose body parts are appended, with the same tail after the last part. A part is in the file completely or
/// not at all, also on a full disk. Nothing waits in a buffer, so that `body_size` only counts what the system has
/// taken.
class GrowingFile {
 public:
  /// Creates a new file, which begins with `head`.
  GrowingFile(const std::filesystem::path& path, std::string_view head, std::string_view tail);
  /// Opens an existing file of at least `body_size` bytes and removes what follows them.
  GrowingFile(const std::filesystem::path& path, std::uint64_t body_size, std::string_view tail);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Appends a part. Throws WriteError; the file is then what it was before.
  void append(std::string_view part);
  /// Cuts the body back to an earlier size.
  void cut(std::uint64_t body_size);
  /// Waits until the disk has the whole file. Throws WriteError.
  void synchronize();

  std::uint64_t body_size() const { return body_size_; }

 private:
  /// Opens the file; once this is done, the destructor closes it even if another constructor fails.
  GrowingFile(const std::filesystem::path& path, std::string_view tail, int flags);
  /// Writes the tail after the body and cuts the file there. Returns false, with the reason in errno, if that fails.
  bool end_body();

  std::string name_, tail_;
  int descriptor_;
  std::uint64_t body_size_ = 0;
};

}  // namespace tanor::report
