#pragma once

#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "report/checksum.hpp"

namespace tanor::report {

/// The machine could not store something: "cannot write <path>: <reason>".
class WriteError : public std::runtime_error {
 public:
  /// Takes the reason from `errno`.
  explicit WriteError(const std::string& path);
  WriteError(const std::string& path, const std::string& reason);
};

/// A file that is being written. Every failure is a WriteError, also that of a full disk which shows late.
class OutputFile {
 public:
  explicit OutputFile(const std::filesystem::path& path);
  static OutputFile standard_output();

  void write(std::string_view bytes);
  void write(std::span<const double> numbers);
  /// Adds everything that is written from now on to a checksum, which must outlive the file.
  void sum_into(Checksum* sum) { sum_ = sum; }
  void flush();        ///< hands everything written so far to the operating system
  void synchronize();  ///< waits until the disk has it
  void close();        ///< throws where the file is not complete; the destructor closes silently

 private:
  using Handle = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
  OutputFile(std::string name, Handle file);

  std::string name_;
  Handle file_;
  Checksum* sum_ = nullptr;
};

/// Replaces a whole file. A reader sees the old file or the new one, never a part, whenever the program stops.
void replace_file(const std::filesystem::path& path, const std::function<void(OutputFile*)>& write_content);

/// Whether to wait until the disk has a file, which takes some milliseconds. Then a machine that stops leaves the old
/// file or the new one, too.
enum class Wait { No, ForDisk };
void replace_file(const std::filesystem::path& path, Wait wait, const std::function<void(OutputFile*)>& write_content);

/// Makes a folder and the folders above it.
void make_folder(const std::filesystem::path& path);

/// Removes a file of ours, and what a program that was killed has left of its replacement. Neither need exist.
void remove_file(const std::filesystem::path& path);

}  // namespace tanor::report
