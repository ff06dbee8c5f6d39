#include "report/output_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

std::FILE* open_or_throw(const fs::path& path, const char* mode) {
  std::FILE* file = std::fopen(path.c_str(), mode);
  if (!file) throw WriteError(path.string());
  return file;
}

void throw_on(const std::error_code& error, const fs::path& path) {
  if (error) throw WriteError(path.string(), error.message());
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

OutputFile::OutputFile(const fs::path& path) : OutputFile(path.string(), {open_or_throw(path, "wb"), &std::fclose}) {}

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

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) throw WriteError(name_);
}

void OutputFile::synchronize() {
  flush();
  if (fsync(fileno(file_.get())) != 0 && errno != EINVAL) throw WriteError(name_);  // EINVAL: nothing to wait for
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
