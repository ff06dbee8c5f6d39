#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace tanor::report {

/// A file to whose body parts are appended; the same words end it after every part. A part is in it as a whole or not
/// at all, also on a full disk, and nothing waits in a buffer: `body_size` never counts what the system has not taken.
class GrowingFile {
 public:
  /// A new file, which begins with `head`.
  GrowingFile(const std::filesystem::path& path, std::string_view head, std::string_view tail);
  /// An existing file of at least `body_size` bytes; what stands behind them goes.
  GrowingFile(const std::filesystem::path& path, std::uint64_t body_size, std::string_view tail);
  ~GrowingFile();
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;

  /// Throws WriteError; the file is then what it was before.
  void append(std::string_view part);
  /// Takes the body back to an earlier size.
  void cut(std::uint64_t body_size);
  /// Waits until the disk has all of it. Throws WriteError.
  void synchronize();

  std::uint64_t body_size() const { return body_size_; }

 private:
  /// The tail behind the body, and nothing behind the tail; false, with the reason in errno, where that fails.
  bool end_body();

  std::string name_, tail_;
  int descriptor_;
  std::uint64_t body_size_ = 0;
};

}  // namespace tanor::report
