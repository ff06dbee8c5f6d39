#include "report/array_writer.hpp"

#include <string>
#include <utility>

#include "report/npy.hpp"

namespace tanor::report {

ArrayWriter::ArrayWriter(JsonWriter* json, std::filesystem::path prefix, std::size_t num_points) : json_(json) {
  if (num_points > largest_inline) prefix_ = std::move(prefix);
}

ArrayWriter ArrayWriter::with_prefix(std::string_view words) const {
  ArrayWriter result(*this);
  if (prefix_) result.prefix_ = prefix_->string() + std::string(words);
  return result;
}

void ArrayWriter::write_points(std::string_view key, const Numbers& numbers) {
  write(key, numbers, 3);
}
void ArrayWriter::write_list(std::string_view key, const Numbers& numbers) {
  write(key, numbers, 1);
}

void ArrayWriter::write_rows(std::string_view key, const Numbers& numbers, std::size_t columns) {
  if (numbers && !prefix_) {
    json_->key(key).rows(*numbers, columns);
  } else {
    write(key, numbers, columns);
  }
}

void ArrayWriter::write_booleans(std::string_view key, const std::vector<bool>& values) {
  json_->key(key);
  if (prefix_) {
    write_npy_booleans(name_file(key), values);
    return;
  }
  json_->begin_array();
  for (const bool value : values) json_->value(value);
  json_->end_array();
}

void ArrayWriter::write(std::string_view key, const Numbers& numbers, std::size_t columns) {
  json_->key(key);
  if (!numbers) {
    json_->null();
  } else if (prefix_) {
    write_npy(name_file(key), *numbers, columns);
  } else if (columns == 1) {
    json_->numbers(*numbers);
  } else {
    json_->rows(*numbers, columns);
  }
}

std::filesystem::path ArrayWriter::name_file(std::string_view key) {
  std::filesystem::path file = prefix_->string() + std::string(key) + ".npy";
  json_->value(file.filename().string());
  return file;
}

}  // namespace tanor::report
