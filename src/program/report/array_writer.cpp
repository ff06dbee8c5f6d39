#include "report/array_writer.hpp"

#include <string>
#include <utility>

#include "report/npy.hpp"

namespace tanor::report {

ArrayWriter::ArrayWriter(JsonObjectFile* json, std::filesystem::path prefix, std::size_t num_points) : json_(json) {
  if (num_points > largest_inline) prefix_ = std::move(prefix);
}

ArrayWriter ArrayWriter::with_prefix(std::string_view words) const {
  ArrayWriter result(*this);
  if (prefix_) result.prefix_ = prefix_->string() + std::string(words);
  return result;
}

void ArrayWriter::write_points(std::string_view key, const Numbers& numbers) const {
  write_rows(key, numbers, 3);
}

void ArrayWriter::write_list(std::string_view key, const Numbers& numbers) const {
  if (prefix_ || !numbers) return write_rows(key, numbers, 1);
  json_->add_numbers(key, *numbers);
}

void ArrayWriter::write_rows(std::string_view key, const Numbers& numbers, std::size_t columns) const {
  if (!numbers) return json_->add(key, {});
  if (!prefix_) return json_->add_rows(key, *numbers, columns);
  write_npy(name_file(key), *numbers, columns);
  json_->add(key, name_file(key).filename().string());
}

void ArrayWriter::write_booleans(std::string_view key, const std::optional<std::vector<bool>>& values) const {
  if (!prefix_ || !values) return json_->add(key, json_or_null(values));
  write_npy_booleans(name_file(key), *values);
  json_->add(key, name_file(key).filename().string());
}

std::filesystem::path ArrayWriter::name_file(std::string_view key) const {
  return prefix_->string() + std::string(key) + ".npy";
}

}  // namespace tanor::report
