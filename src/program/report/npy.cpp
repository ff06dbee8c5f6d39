#include "report/npy.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

namespace tanor::report {

static_assert(std::endian::native == std::endian::little, "'<f8' is written as it lies in memory");

namespace {

constexpr std::string_view magic{"\x93NUMPY\x01\x00", 8};
// Magic, two bytes of length and the text together are a multiple of 64, so that the numbers can be mapped into memory.
constexpr std::size_t alignment = 64;

}  // namespace

std::string make_npy_header(std::string_view type, const std::vector<std::size_t>& shape, std::size_t size) {
  const char *const comma = shape.size() == 1 ? "," : "", *const quote = type.starts_with('[') ? "" : "'";
  std::string text = fmt::format("{{'descr': {}{}{}, 'fortran_order': False, 'shape': ({}{}), }}", quote, type, quote,
                                 fmt::join(shape, ", "), comma);
  const std::size_t length = magic.size() + 2 + text.size() + 1, wanted = std::max(length, size);
  text.append(wanted - length + (alignment - wanted % alignment) % alignment, ' ');
  text += '\n';
  const auto bytes = static_cast<std::uint16_t>(text.size());
  return std::string(magic) + static_cast<char>(bytes & 0xFF) + static_cast<char>(bytes >> 8) + text;
}

void write_npy(OutputFile* file, std::span<const double> numbers, std::size_t columns) {
  write_npy(file, numbers, columns == 1 ? std::vector{numbers.size()} : std::vector{numbers.size() / columns, columns});
}

void write_npy(OutputFile* file, std::span<const double> numbers, const std::vector<std::size_t>& shape) {
  file->write(make_npy_header("<f8", shape));
  file->write(numbers);
}

void write_npy(const std::filesystem::path& path, std::span<const double> numbers, std::size_t columns) {
  replace_file(path, [&](OutputFile* file) { write_npy(file, numbers, columns); });
}

void write_npy_booleans(const std::filesystem::path& path, const std::vector<bool>& values) {
  replace_file(path, [&](OutputFile* file) {
    file->write(make_npy_header("|b1", {values.size()}));
    file->write(std::string(values.begin(), values.end()));
  });
}

}  // namespace tanor::report
