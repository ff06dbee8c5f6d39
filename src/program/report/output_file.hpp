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
  static OutputFile standard_output();

  void write(std::string_view bytes);
  void write(std::span<const double> numbers);
  void seek(std::uint64_t place);  ///< continues writing at a position counted from the beginning
  std::uint64_t tell() const;      ///< writing position
  void flush();                    ///< hands everything written so far to the operating system
  void synchronize();              ///< waits until the disk has everything
  void close();                    ///< reports success or failure; the destructor closes silently

 private:
  using Handle = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  OutputFile(std::string name, Handle file);

  std::string name_;
  Handle file_;
};

/// Replaces a whole file. Readers see the old or the new one, never a part, whenever the program stops.
void replace_file(const std::filesystem::path& path, const std::function<void(OutputFile*)>& write_content);

/// Tells whether to wait until the disk has a file (some milliseconds). Then the old or the new file also survives a
/// stop of the machine.
enum class Wait { No, ForDisk };
void replace_file(const std::filesystem::path& path, Wait wait, const std::function<void(OutputFile*)>& write_content);

/// Makes a folder and the folders above it.
void make_folder(const std::filesystem::path& path);

/// Removes a file, and the unfinished replacement that a killed program left; neither need exist.
void remove_file(const std::filesystem::path& path);

}  // namespace tanor::report
