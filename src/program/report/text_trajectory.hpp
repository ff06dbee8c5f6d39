#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "report/compression.hpp"
#include "report/frame_file.hpp"
#include "report/growing_file.hpp"

namespace tanor::report {

/// A text file that grows by one piece for each frame; each is complete before the next one begins. If the name ends in
/// ".gz", each piece is a separate gzip member, so that such a file can also be read whenever the program stops.
class TextTrajectory : public FrameFile {
 public:
  /// Creates a file that begins with `head`, or continues an existing one after `mark` if that is not 0.
  TextTrajectory(const std::filesystem::path& path, std::string_view head, std::uint64_t mark)
      : is_compressed_(path.extension() == ".gz"),
        file_(mark > 0 ? GrowingFile(path, mark, "") : GrowingFile(path, pack(head), "")) {}

  void write(const Frame& frame) override {
    buffer_.clear();
    print(frame, &buffer_);
    file_.append(pack({buffer_.data(), buffer_.size()}));
  }
  std::uint64_t mark() const override { return file_.body_size(); }
  void cut(std::uint64_t mark) override { file_.cut(mark); }
  void synchronize() override { file_.synchronize(); }

 protected:
  virtual void print(const Frame& frame, fmt::memory_buffer* text) const = 0;

 private:
  std::string pack(std::string_view text) const {
    return is_compressed_ && !text.empty() ? gzip(text) : std::string(text);
  }

  bool is_compressed_;
  GrowingFile file_;
  fmt::memory_buffer buffer_;
};

}  // namespace tanor::report
