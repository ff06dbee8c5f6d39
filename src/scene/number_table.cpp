#include "scene/number_table.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/text_file.hpp"

namespace tanor::scene {
namespace {

/// Calls `use(field)` for each field between the commas of a line.
template <class Use>
void for_each_field(std::string_view line, Use use) {
  while (true) {
    const std::size_t comma = line.find(',');
    use(trim(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

NumberTable read_csv(const std::string& name, std::string_view text) {
  NumberTable table;
  LineReader lines(name, text);
  for (bool is_first = true; lines.next();) {
    if (trim(lines.line()).empty()) continue;
    const bool is_header = is_first && !parse_number(trim(lines.line().substr(0, lines.line().find(','))));
    is_first = false;
    if (is_header) continue;
    const std::size_t before = table.values.size();
    for_each_field(lines.line(), [&](std::string_view field) {
      const auto number = parse_number(field);
      if (!number) lines.fail(field, "a finite number");
      table.values.push_back(*number);
    });
    const std::size_t columns = table.values.size() - before;
    if (table.rows++ == 0) table.columns = columns;
    if (columns != table.columns)
      lines.complain(fmt::format("found {} columns, wanted {} as in the first row", columns, table.columns));
  }
  return table;
}

/// The text between `'key': ` and one of the closing characters in the header of an npy file.
std::string_view npy_field(std::string_view header, std::string_view key, char close) {
  const std::size_t found = header.find(key);
  if (found == std::string_view::npos) return {};
  header = header.substr(found + key.size());
  return trim(header.substr(0, header.find(close)));
}

/// The format: https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html
NumberTable read_npy(const std::string& name, std::string_view text) {
  static_assert(std::endian::native == std::endian::little, "npy files are read as they lie in memory");
  const auto check = [&](bool good, std::string_view wanted) {
    if (!good) throw InputError("", fmt::format("{}: wanted {}", name, wanted));
  };

  constexpr std::string_view magic = "\x93NUMPY";
  check(text.starts_with(magic) && text.size() >= 12, "a NumPy file");
  const auto byte = [&](std::size_t k) { return static_cast<std::size_t>(static_cast<unsigned char>(text[k])); };
  const bool is_short = text[6] == 1;  // major version: two bytes of length, later four
  const std::size_t start = is_short ? 10 : 12;
  const std::size_t length = byte(8) + (byte(9) << 8) + (is_short ? 0 : (byte(10) << 16) + (byte(11) << 24));
  check(text.size() >= start + length, "a NumPy file with a whole header");
  const std::string_view header = text.substr(start, length), data = text.substr(start + length);

  check(npy_field(header, "'descr':", ',') == "'<f8'", "numbers of type '<f8' (float64)");
  check(npy_field(header, "'fortran_order':", ',') == "False", "an array in C order");
  std::vector<std::size_t> shape;
  for_each_field(npy_field(header, "'shape': (", ')'), [&](std::string_view field) {
    const auto size = parse_integer(field);
    if (size && *size >= 0) shape.push_back(static_cast<std::size_t>(*size));
  });
  check(shape.size() == 1 || shape.size() == 2, "an array with one or two dimensions");

  NumberTable table{.rows = shape[0], .columns = shape.size() == 2 ? shape[1] : 1, .values = {}};
  const std::size_t count = data.size() / sizeof(double);
  check(data.size() % sizeof(double) == 0 && (table.columns == 0 ? count == 0 : count / table.columns == table.rows) &&
            count == table.rows * table.columns,
        "as many numbers as its shape says");
  table.values.resize(count);
  std::memcpy(table.values.data(), data.data(), data.size());
  const auto bad =
      std::find_if_not(table.values.begin(), table.values.end(), [](double x) { return std::isfinite(x); });
  if (bad != table.values.end())
    throw InputError("", fmt::format("{}, row {}: found {}, wanted a finite number", name,
                                     static_cast<std::size_t>(bad - table.values.begin()) / table.columns, *bad));
  return table;
}

}  // namespace

NumberTable read_number_table(const std::filesystem::path& file) {
  const std::string text = read_text(file), name = file.filename().string();
  return file.extension() == ".npy" ? read_npy(name, text) : read_csv(name, text);
}

}  // namespace tanor::scene
