#include "report/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "base/checksum.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view last_words = "checksum ";

std::FILE* open_or_throw(const fs::path& path, const char* mode) {
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (!file) throw WriteError(path.string());
  return file;
}

void throw_on(const std::error_code& error, const fs::path& path) {
  if (error) throw WriteError(path.string(), error.message());
}

/// Returns the last line of a sealed file.
std::string last_line(const detail::Checksum& sum) {
  return std::string(last_words) + sum.text() + "\n";
}

/// Returns the name of a file's replacement until it is complete.
fs::path unfinished(const fs::path& path) {
  return path.string() + ".part";
}

/// Waits until the disk has the names in a folder.
void synchronize_folder(const fs::path& path) {
  const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder < 0) throw WriteError(path.string());
  const bool is_done = fsync(folder) == 0 || errno == EINVAL;  // EINVAL: nothing to wait for
  const int reason = errno;
  close(folder);
  if (!is_done) throw WriteError(path.string(), std::strerror(reason));
}

}  // namespace

WriteError::WriteError(const std::string& path) : WriteError(path, std::strerror(errno)) {}

WriteError::WriteError(const std::string& path, const std::string& reason)
    : std::runtime_error("cannot write " + path + ": " + reason) {}

OutputFile::OutputFile(std::string name, Handle file) : name_(std::move(name)), file_(std::move(file)) {}

OutputFile::OutputFile(const fs::path& path, const char* mode)
    : OutputFile(path.string(), {open_or_throw(path, mode), &std::fclose}) {}

OutputFile OutputFile::standard_output() {
  // Standard output must not be closed here. Flushing tells whether it took everything.
  return {"standard output", {stdout, &std::fflush}};
}

void OutputFile::write(std::string_view bytes) {
  if (bytes.empty()) return;  // fwrite must not see a null pointer
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) throw WriteError(name_);
}

void OutputFile::write(std::span<const double> numbers) {
  write(std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()));
}

void OutputFile::seek(std::uint64_t place) {
  if (fseeko(file_.get(), static_cast<off_t>(place), SEEK_SET) != 0) throw WriteError(name_);
}

std::uint64_t OutputFile::tell() const {
  return static_cast<std::uint64_t>(ftello(file_.get()));
}

void OutputFile::cut() {
  if (ftruncate(fileno(file_.get()), static_cast<off_t>(tell())) != 0) throw WriteError(name_);
}

void OutputFile::stop_buffering() {
  std::setvbuf(file_.get(), nullptr, _IONBF, 0);
}

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) throw WriteError(name_);
}

void OutputFile::synchronize() {
  flush();
  if (fdatasync(fileno(file_.get())) != 0 && errno != EINVAL) throw WriteError(name_);  // EINVAL: nothing to wait for
}

void OutputFile::close() {
  const auto close_handle = file_.get_deleter();
  if (close_handle(file_.release()) != 0) throw WriteError(name_);
}

void replace_file(const fs::path& path, const std::function<void(OutputFile*)>& write_content) {
  const fs::path part = unfinished(path);
  try {
    OutputFile file(part);
    write_content(&file);
    file.close();
  } catch (...) {
    std::error_code ignored;
    fs::remove(part, ignored);
    throw;
  }
  std::error_code error;
  fs::rename(part, path, error);
  throw_on(error, path);
}

void replace_file(const fs::path& path, Wait wait, const std::function<void(OutputFile*)>& write_content) {
  if (wait == Wait::No) return replace_file(path, write_content);
  replace_file(path, [&](OutputFile* file) {
    write_content(file);
    file->synchronize();
  });
  synchronize_folder(path.has_parent_path() ? path.parent_path() : ".");
}

void write_sealed(const fs::path& path, Wait wait, std::string_view first_line,
                  std::initializer_list<std::string_view> content) {
  detail::Checksum sum;
  replace_file(path, wait, [&](OutputFile* file) {
    const auto write = [&](std::string_view piece) {
      sum.add(piece);
      file->write(piece);
    };
    write(first_line);
    for (const std::string_view piece : content) write(piece);
    file->write(last_line(sum));
  });
}

Seal open_sealed(std::string_view text, std::string_view first_line, std::string_view* content) {
  if (!text.starts_with(first_line)) return Seal::OtherFormat;
  const std::size_t end = text.rfind(last_words);
  if (end == std::string_view::npos || end < first_line.size()) return Seal::Damaged;
  detail::Checksum sum;
  sum.add(text.substr(0, end));
  if (text.substr(end) != last_line(sum)) return Seal::Damaged;
  *content = text.substr(first_line.size(), end - first_line.size());
  return Seal::Sound;
}

GrowingFile::GrowingFile(const fs::path& path, std::string_view head, std::string_view tail)
    : file_(path), tail_(tail) {
  file_.stop_buffering();
  append(head);
}

GrowingFile::GrowingFile(const fs::path& path, std::uint64_t body_size, std::string_view tail)
    : file_(path, "r+be"), tail_(tail) {
  file_.stop_buffering();
  cut(body_size);
}

void GrowingFile::append(std::string_view part) {
  try {
    file_.seek(body_size_);
    // Both are written in one piece, so that nobody sees the part without the tail.
    file_.write(tail_.empty() ? part : std::string_view(std::string(part) + tail_));
  } catch (const WriteError&) {
    cut(body_size_);  // this needs no more room than the file had before
    throw;
  }
  body_size_ += part.size();
}

void GrowingFile::cut(std::uint64_t body_size) {
  body_size_ = body_size;
  file_.seek(body_size);
  file_.write(tail_);
  file_.cut();
}

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  throw_on(error, path);
}

void remove_file(const fs::path& path) {
  for (const fs::path& name : {path, unfinished(path)}) {
    std::error_code error;
    fs::remove(name, error);
    throw_on(error, name);
  }
}

}  // namespace tanor::report
