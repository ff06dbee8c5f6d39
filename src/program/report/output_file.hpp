#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <initializer_list>
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
  /// Opens a new file, or another one in a mode of std::fopen.
  explicit OutputFile(const std::filesystem::path& path, const char* mode = "wbe");
  static OutputFile standard_output();

  void write(std::string_view bytes);
  void write(std::span<const double> numbers);
  void seek(std::uint64_t place);  ///< continues writing at a position counted from the beginning
  std::uint64_t tell() const;      ///< writing position
  void cut();                      ///< ends the file at the writing position
  void flush();                    ///< hands everything written so far to the operating system
  void synchronize();              ///< waits until the disk has everything
  void close();                    ///< reports success or failure; the destructor closes silently
  void stop_buffering();           ///< hands all that is written from now on to the operating system at once

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

/// Replaces a sealed file, which is read back: a first line that names the format, the content, and a last line with
/// the checksum of everything before. The content comes in pieces; if it is binary, it must follow a line that ends.
void write_sealed(const std::filesystem::path& path, Wait wait, std::string_view first_line,
                  std::initializer_list<std::string_view> content);

enum class Seal { Sound, OtherFormat, Damaged };
/// Finds the content of a sealed file between the first line and the last, if both are correct.
Seal open_sealed(std::string_view text, std::string_view first_line, std::string_view* content);

/// A file to whose body parts are appended, with the same tail after the last part. A part is in the file completely or
/// not at all, also on a full disk. Nothing waits in a buffer, so that `body_size` only counts what the system has
/// taken.
class GrowingFile {
 public:
  /// Creates a new file, which begins with `head`.
  GrowingFile(const std::filesystem::path& path, std::string_view head, std::string_view tail);
  /// Opens an existing file of at least `body_size` bytes and removes what follows them.
  GrowingFile(const std::filesystem::path& path, std::uint64_t body_size, std::string_view tail);

  /// Appends a part. Throws WriteError; the file is then what it was before.
  void append(std::string_view part);
  /// Cuts the body back to an earlier size.
  void cut(std::uint64_t body_size);
  /// Waits until the disk has the whole file. Throws WriteError.
  void synchronize() { file_.synchronize(); }

  std::uint64_t body_size() const { return body_size_; }

 private:
  OutputFile file_;
  std::string tail_;
  std::uint64_t body_size_ = 0;
};

/// Makes a folder and the folders above it.
void make_folder(const std::filesystem::path& path);

/// Removes a file, and the unfinished replacement that a killed program left; neither need exist.
void remove_file(const std::filesystem::path& path);

}  // namespace tanor::report
