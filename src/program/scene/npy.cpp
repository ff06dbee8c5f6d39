#include "scene/npy.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <optional>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

static_assert(std::endian::native == std::endian::little, "npy files are read as they lie in memory");

/// Returns the text between `'key': ` and the closing character in the header, or nothing if one of them is missing.
std::string_view find_field(std::string_view header, std::string_view key, char close) {
  const std::size_t begin = header.find(key);
  if (begin == std::string_view::npos) return {};
  header.remove_prefix(begin + key.size());
  const std::size_t end = header.find(close);
  return end == std::string_view::npos ? std::string_view() : trim(header.substr(0, end));
}

/// Reads a shape such as "3, 4" or "3," (a vector).
std::optional<std::vector<std::size_t>> read_shape(std::string_view list) {
  std::vector<std::size_t> shape;
  while (!list.empty()) {
    const std::size_t comma = list.find(',');
    const auto extent = parse_integer(trim(list.substr(0, comma)));
    if (!extent || *extent < 0) return std::nullopt;
    shape.push_back(static_cast<std::size_t>(*extent));
    list = comma == std::string_view::npos ? std::string_view() : trim(list.substr(comma + 1));
  }
  return shape;
}

/// Returns the product of the shape, or nothing if it exceeds `most`.
std::optional<std::size_t> count_numbers(const std::vector<std::size_t>& shape, std::size_t most) {
  if (std::find(shape.begin(), shape.end(), 0u) != shape.end()) return 0;
  std::size_t count = 1;
  for (const std::size_t extent : shape) {
    if (extent > most / count) return std::nullopt;
    count *= extent;
  }
  return count;
}

}  // namespace

// The format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
NpyArray read_npy(const std::string& name, std::string_view* bytes) {
  const auto check = [&](bool good, std::string_view wanted) {
    if (!good) throw InputError(name, fmt::format("wanted {}", wanted));
  };

  const std::string_view text = *bytes;
  check(text.starts_with("\x93NUMPY") && text.size() >= 12, "a NumPy file");
  const auto byte = [&](std::size_t k) { return static_cast<std::size_t>(static_cast<unsigned char>(text[k])); };
  const bool is_short = text[6] == 1;  // major version 1 has two bytes of length, later ones four
  const std::size_t start = is_short ? 10 : 12;
  const std::size_t length = byte(8) + (byte(9) << 8) + (is_short ? 0 : (byte(10) << 16) + (byte(11) << 24));
  check(text.size() >= start + length, "a NumPy file with a whole header");
  const std::string_view header = text.substr(start, length), data = text.substr(start + length);

  check(find_field(header, "'descr':", ',') == "'<f8'", "numbers of type '<f8' (float64)");
  check(find_field(header, "'fortran_order':", ',') == "False", "an array in C order");
  const auto shape = read_shape(find_field(header, "'shape': (", ')'));
  check(shape && !shape->empty(), "a shape of whole numbers, one or more");
  const auto count = count_numbers(*shape, data.size() / sizeof(double));
  check(count.has_value(), "as many numbers as its shape says");

  NpyArray array{.shape = *shape, .numbers = std::vector<double>(*count)};
  const std::size_t size = *count * sizeof(double);
  if (size > 0) std::memcpy(array.numbers.data(), data.data(), size);
  *bytes = data.substr(size);
  return array;
}

}  // namespace tanor::scene
