#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/json_text.hpp"

namespace tanor::report {

/// Packs arrays into one block of bytes that a page in a browser unpacks. All arrays are deflated together and encoded
/// in base64, and a list tells where each begins.
class PackedBytes {
 public:
  void add(std::string_view name, std::span<const std::int32_t> numbers);
  /// Adds whole numbers 0 … 65535 as differences from the row before, low bytes first and then the high ones. Numbers
  /// that change little from row to row pack well this way.
  void add_rows(std::string_view name, std::span<const std::uint16_t> numbers, std::size_t columns);

  Json list() const { return list_; }
  std::string text() const;  ///< base64 of zlib's deflate

 private:
  void begin(std::string_view name, std::string_view type, std::size_t count, std::size_t columns);

  Json list_ = Json::array();
  std::vector<std::uint8_t> bytes_;
};

/// Maps a number between `least` and `most` to 0 … 65534, and one that is not known to 65535.
std::uint16_t to_16_bits(double number, double least, double most);

}  // namespace tanor::report
