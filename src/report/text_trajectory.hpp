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

/// A text file that grows by one piece a frame, each complete before the next one begins. With a name that ends in
/// ".gz" each piece is a gzip member of its own, so that such a file can be read whenever the program stops, too.
class TextTrajectory : public FrameFile {
 public:
  /// A new file that begins with `head`, or, where there is a mark, an existing one that goes on behind it.
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
