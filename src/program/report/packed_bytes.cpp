#include "report/packed_bytes.hpp"

#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace tanor::report {

namespace {

std::string to_base64(std::span<const std::uint8_t> bytes) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve(4 * (bytes.size() + 2) / 3);
  for (std::size_t k = 0; k < bytes.size(); k += 3) {
    const std::size_t there = std::min<std::size_t>(3, bytes.size() - k);
    std::uint32_t word = 0;
    for (std::size_t j = 0; j < 3; ++j) word = word << 8 | (j < there ? bytes[k + j] : 0u);
    for (std::size_t j = 0; j < 4; ++j) text += j <= there ? digits[word >> (18 - 6 * j) & 63] : '=';
  }
  return text;
}

}  // namespace

std::uint16_t to_16_bits(double number, double least, double most) {
  if (!std::isfinite(number)) return 65535;
  if (!(most > least)) return 0;
  return static_cast<std::uint16_t>(std::lround(65534.0 * std::clamp((number - least) / (most - least), 0.0, 1.0)));
}

void PackedBytes::begin(std::string_view name, std::string_view type, std::size_t count, std::size_t columns) {
  list_.push_back({{"name", name}, {"type", type}, {"at", bytes_.size()}, {"count", count}, {"columns", columns}});
}

void PackedBytes::add(std::string_view name, std::span<const std::int32_t> numbers) {
  begin(name, "int32", numbers.size(), 1);
  for (const std::int32_t number : numbers) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes_.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(number) >> shift & 255u));
  }
}

void PackedBytes::add_rows(std::string_view name, std::span<const std::uint16_t> numbers, std::size_t columns) {
  begin(name, "delta16", numbers.size(), columns);
  for (const int shift : {0, 8}) {
    for (std::size_t k = 0; k < numbers.size(); ++k) {
      const unsigned before = k >= columns ? numbers[k - columns] : 0u;
      bytes_.push_back(static_cast<std::uint8_t>((numbers[k] - before) >> shift & 255u));
    }
  }
}

std::string PackedBytes::text() const {
  uLongf size = compressBound(bytes_.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, bytes_.data(), bytes_.size(), 6) != Z_OK)
    throw std::runtime_error("the motion could not be packed for report.html");
  return to_base64({packed.data(), size});
}

}  // namespace tanor::report
