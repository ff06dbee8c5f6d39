#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace tanor::report {

/// The machine could not store something: "cannot write <path>: <reason>".
class WriteError : public std::runtime_error {
 public:
  /// Takes the reason from `errno`.
  explicit WriteError(const std::string& path);
  WriteError(const std::string& path, const std::string& reason);
};

/// A file being written. Every failure, also a late one of a full disk, is a WriteError.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  /// An existing file, cut to `size` bytes; what is written is added there.
  OutputFile(const std::filesystem::path& path, std::uint64_t size);
  static OutputFile standard_output();

  void write(std::string_view bytes);
  void write(std::span<const double> numbers);
  void flush();  ///< hands everything written so far to the operating system
  void close();  ///< the last word on success; the destructor closes without a word

  std::uint64_t size() const { return size_; }

 private:
  using Handle = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  OutputFile(std::string name, Handle file, std::uint64_t size);

  std::string name_;
  Handle file_;
  std::uint64_t size_ = 0;
};

/// Replaces a whole file: who reads it sees the old one or the new one, never a part, whenever the program stops.
void replace_file(const std::filesystem::path& path, const std::function<void(OutputFile*)>& write_content);

/// Makes a folder and the folders above it.
void make_folder(const std::filesystem::path& path);

/// Removes a file of ours; it need not exist.
void remove_file(const std::filesystem::path& path);

}  // namespace tanor::report
