#include "report/array_writer.hpp"

#include <string>
#include <utility>

#include "report/npy.hpp"

namespace tanor::report {

ArrayWriter::ArrayWriter(std::filesystem::path prefix, std::size_t num_points) {
  if (num_points > largest_inline) prefix_ = std::move(prefix);
}

ArrayWriter ArrayWriter::with_prefix(std::string_view words) const {
  ArrayWriter result(*this);
  if (prefix_) result.prefix_ = prefix_->string() + std::string(words);
  return result;
}

Json ArrayWriter::write_points(std::string_view key, const Numbers& numbers) const {
  return write_rows(key, numbers, 3);
}

Json ArrayWriter::write_list(std::string_view key, const Numbers& numbers) const {
  return prefix_ || !numbers ? write_rows(key, numbers, 1) : Json(*numbers);
}

Json ArrayWriter::write_rows(std::string_view key, const Numbers& numbers, std::size_t columns) const {
  if (!numbers) return {};
  if (prefix_) {
    write_npy(name_file(key), *numbers, columns);
    return name_file(key).filename().string();
  }
  Json rows = Json::array();
  for (std::size_t begin = 0; begin < numbers->size(); begin += columns)
    rows.push_back(numbers->subspan(begin, columns));
  return rows;
}

Json ArrayWriter::write_booleans(std::string_view key, const std::vector<bool>& values) const {
  if (!prefix_) return values;
  write_npy_booleans(name_file(key), values);
  return name_file(key).filename().string();
}

std::filesystem::path ArrayWriter::name_file(std::string_view key) const {
  return prefix_->string() + std::string(key) + ".npy";
}

}  // namespace tanor::report
