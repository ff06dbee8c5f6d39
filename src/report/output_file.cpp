#include "report/output_file.hpp"

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

}  // namespace

WriteError::WriteError(const std::string& path) : WriteError(path, std::strerror(errno)) {}

WriteError::WriteError(const std::string& path, const std::string& reason)
    : std::runtime_error("cannot write " + path + ": " + reason) {}

OutputFile::OutputFile(std::string name, Handle file, std::uint64_t size)
    : name_(std::move(name)), file_(std::move(file)), size_(size) {}

OutputFile::OutputFile(const fs::path& path)
    : OutputFile(path.string(), {open_or_throw(path, "wb"), &std::fclose}, 0) {}

OutputFile::OutputFile(const fs::path& path, std::uint64_t size)
    : OutputFile(path.string(), {open_or_throw(path, "ab"), &std::fclose}, size) {
  std::error_code error;
  fs::resize_file(path, size, error);
  throw_on(error, path);
}

OutputFile OutputFile::standard_output() {
  // It is not ours to close: flushing says whether it took everything.
  return {"standard output", {stdout, &std::fflush}, 0};
}

void OutputFile::write(std::string_view bytes) {
  if (bytes.empty()) return;  // fwrite must not see a null pointer
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) throw WriteError(name_);
  size_ += bytes.size();
}

void OutputFile::write(std::span<const double> numbers) {
  write(std::string_view(reinterpret_cast<const char*>(numbers.data()), numbers.size_bytes()));
}

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) throw WriteError(name_);
}

void OutputFile::close() {
  const auto close_handle = file_.get_deleter();
  if (close_handle(file_.release()) != 0) throw WriteError(name_);
}

void replace_file(const fs::path& path, const std::function<void(OutputFile*)>& write_content) {
  const fs::path part = path.string() + ".part";
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

void make_folder(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  throw_on(error, path);
}

void remove_file(const fs::path& path) {
  std::error_code error;
  fs::remove(path, error);
  throw_on(error, path);
}

}  // namespace tanor::report
