#include "scene/number_table.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/npy.hpp"
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
    for_each_field(lines.line(), [&](std::string_view field) { table.values.push_back(lines.read_number(field)); });
    const std::size_t columns = table.values.size() - before;
    if (table.rows++ == 0) table.columns = columns;
    if (columns != table.columns)
      lines.complain(fmt::format("found {} columns, wanted {} as in the first row", columns, table.columns));
  }
  if (table.rows == 0) throw InputError(name, "wanted at least one row of numbers");
  return table;
}

NumberTable read_npy_table(const std::string& name, std::string_view bytes) {
  NpyArray array = read_npy(name, &bytes);
  if (!bytes.empty()) throw InputError(name, "wanted as many numbers as its shape says");
  if (array.shape.size() > 2) throw InputError(name, "wanted an array with one or two dimensions");
  // Rows without columns hold no numbers, and there may be 2^63 of them.
  if (array.numbers.empty()) throw InputError(name, "wanted at least one number");
  NumberTable table{.rows = array.shape[0],
                    .columns = array.shape.size() == 2 ? array.shape[1] : 1,
                    .values = std::move(array.numbers)};
  const auto bad =
      std::find_if_not(table.values.begin(), table.values.end(), [](double x) { return std::isfinite(x); });
  if (bad != table.values.end()) {
    const std::size_t row = static_cast<std::size_t>(bad - table.values.begin()) / table.columns;
    throw InputError(fmt::format("{}, row {}", name, row), fmt::format("found {}, wanted a finite number", *bad));
  }
  return table;
}

}  // namespace

NumberTable read_number_table(const std::filesystem::path& file) {
  const std::string text = read_text(file), name = file.filename().string();
  return ending_of(file) == ".npy" ? read_npy_table(name, text) : read_csv(name, text);
}

}  // namespace tanor::scene
