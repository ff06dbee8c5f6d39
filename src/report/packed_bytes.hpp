#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "report/json_text.hpp"

namespace tanor::report {

/// Arrays as one run of bytes that a page in a browser unpacks: each deflated with the others and written in base64,
/// with a list that says where each begins.
class PackedBytes {
 public:
  void add(std::string_view name, std::span<const std::int32_t> numbers);
  /// Whole numbers 0 … 65535, less those of the row before, low bytes first and then the high ones: what changes little
  /// from row to row packs well.
  void add_rows(std::string_view name, std::span<const std::uint16_t> numbers, std::size_t columns);

  Json list() const { return list_; }
  std::string text() const;  ///< base64 of zlib's deflate

 private:
  void begin(std::string_view name, std::string_view type, std::size_t count, std::size_t columns);

  Json list_ = Json::array();
  std::vector<std::uint8_t> bytes_;
};

/// Numbers between `least` and `most` in 65536 equal steps.
std::uint16_t to_16_bits(double number, double least, double most);

}  // namespace tanor::report
