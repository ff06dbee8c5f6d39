#include "report/npy.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <fstream>
#include <limits>
#include <sstream>
#include <string_view>

#include <tanor/error.hpp>

namespace tanor::report {

static_assert(std::endian::native == std::endian::little, "'<f8' is written as it lies in memory");

namespace {

constexpr std::string_view magic{"\x93NUMPY\x01\x00", 8};
// Magic, two bytes of length and the text together are a multiple of 64, so that the numbers can be mapped into memory.
constexpr std::size_t alignment = 64;

std::string make_header(std::string_view type, std::size_t size, std::size_t columns) {
  const std::string shape =
      columns == 1 ? fmt::format("({},)", size) : fmt::format("({}, {})", size / columns, columns);
  std::string text = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': {}, }}", type, shape);
  const std::size_t length = magic.size() + 2 + text.size() + 1;
  text.append((alignment - length % alignment) % alignment, ' ');
  text += '\n';
  const auto bytes = static_cast<std::uint16_t>(text.size());
  return std::string(magic) + static_cast<char>(bytes & 0xFF) + static_cast<char>(bytes >> 8) + text;
}

std::string read_bytes(std::istream* stream, std::size_t count, const std::string& name) {
  std::string bytes(count, '\0');
  if (!stream->read(bytes.data(), static_cast<std::streamsize>(count)))
    throw InputError(name, "the .npy array is cut short");
  return bytes;
}

/// The numbers of "'shape': (3, 4), …".
std::vector<std::size_t> read_shape(std::string_view header, const std::string& name) {
  const std::size_t key = header.find("'shape':");
  const std::size_t open = header.find('(', key), end = header.find(')', open);
  if (key == header.npos || open == header.npos || end == header.npos) {
    throw InputError(name, "the .npy header has no shape");
  }
  std::vector<std::size_t> shape;
  std::istringstream list(std::string(header.substr(open + 1, end - open - 1)));
  for (std::size_t extent; list >> extent; list.ignore(1, ',')) shape.push_back(extent);
  if (!list.eof()) throw InputError(name, "the .npy shape is not a list of whole numbers");
  return shape;
}

/// Product of the shape, at most what a file can hold.
std::size_t count_numbers(const std::vector<std::size_t>& shape, const std::string& name) {
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max() / sizeof(double);
  std::size_t count = 1;
  for (const std::size_t extent : shape) {
    if (extent != 0 && count > most / extent) throw InputError(name, "the .npy shape is larger than any memory");
    count *= extent;
  }
  return count;
}

}  // namespace

void write_npy(OutputFile* file, std::span<const double> numbers, std::size_t columns) {
  file->write(make_header("<f8", numbers.size(), columns));
  file->write(numbers);
}

void write_npy(const std::filesystem::path& path, std::span<const double> numbers, std::size_t columns) {
  replace_file(path, [&](OutputFile* file) { write_npy(file, numbers, columns); });
}

void write_npy_booleans(const std::filesystem::path& path, const std::vector<bool>& values) {
  replace_file(path, [&](OutputFile* file) {
    file->write(make_header("|b1", values.size(), 1));
    file->write(std::string(values.begin(), values.end()));
  });
}

NpyArray read_npy(std::istream* stream, const std::string& name) {
  if (read_bytes(stream, magic.size(), name) != magic) throw InputError(name, "not a .npy array of version 1.0");
  const std::string length = read_bytes(stream, 2, name);
  const std::size_t size = static_cast<unsigned char>(length[0]) + 256u * static_cast<unsigned char>(length[1]);
  const std::string header = read_bytes(stream, size, name);
  const bool is_ours =
      header.find("'<f8'") != std::string::npos && header.find("'fortran_order': False") != std::string::npos;
  if (!is_ours) throw InputError(name, "the .npy array must be '<f8' in C order");

  NpyArray array{.shape = read_shape(header, name), .numbers = {}};
  array.numbers.resize(count_numbers(array.shape, name));
  const auto bytes = static_cast<std::streamsize>(array.numbers.size() * sizeof(double));
  if (!stream->read(reinterpret_cast<char*>(array.numbers.data()), bytes))
    throw InputError(name, "the .npy array is cut short");
  return array;
}

NpyArray read_npy(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw InputError(path.string(), "cannot be read");
  return read_npy(&stream, path.string());
}

}  // namespace tanor::report
