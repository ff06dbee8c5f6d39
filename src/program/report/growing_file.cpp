#include "report/growing_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "report/output_file.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

int open_or_throw(const fs::path& path, int flags) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CLOEXEC | flags, 0666);
  if (descriptor < 0) throw WriteError(path.string());
  return descriptor;
}

/// Writes all bytes at an offset of a file. Returns false, with the reason in errno, if not all could be written.
bool write_at(int descriptor, std::uint64_t offset, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = pwrite(descriptor, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
    offset += static_cast<std::uint64_t>(written);
  }
  return true;
}

}  // namespace

GrowingFile::GrowingFile(const fs::path& path, std::string_view tail, int flags)
    : name_(path.string()), tail_(tail), descriptor_(open_or_throw(path, flags)) {}

GrowingFile::GrowingFile(const fs::path& path, std::string_view head, std::string_view tail)
    : GrowingFile(path, tail, O_CREAT | O_TRUNC) {
  append(head);
}

GrowingFile::GrowingFile(const fs::path& path, std::uint64_t body_size, std::string_view tail)
    : GrowingFile(path, tail, 0) {
  cut(body_size);
}

GrowingFile::~GrowingFile() {
  close(descriptor_);
}

void GrowingFile::append(std::string_view part) {
  // Both are written in one piece, so that nobody sees the part without the tail.
  const bool is_written = tail_.empty() ? write_at(descriptor_, body_size_, part)
                                        : write_at(descriptor_, body_size_, std::string(part) + tail_);
  if (is_written) {
    body_size_ += part.size();
    return;
  }
  const int reason = errno;
  end_body();  // this needs no more room than the file had before
  throw WriteError(name_, std::strerror(reason));
}

void GrowingFile::cut(std::uint64_t body_size) {
  body_size_ = body_size;
  if (!end_body()) throw WriteError(name_);
}

void GrowingFile::synchronize() {
  if (fdatasync(descriptor_) != 0 && errno != EINVAL) throw WriteError(name_);  // EINVAL: nothing to wait for
}

bool GrowingFile::end_body() {
  return write_at(descriptor_, body_size_, tail_) &&
         ftruncate(descriptor_, static_cast<off_t>(body_size_ + tail_.size())) == 0;
}

}  // namespace tanor::report
