#include "report/sealed_file.hpp"

#include <fmt/format.h>

#include "base/checksum.hpp"

namespace tanor::report {
using namespace detail;

namespace {

constexpr std::string_view last_words = "checksum ";

std::string last_line(const Checksum& sum) {
  return fmt::format("{}{}\n", last_words, sum.text());
}

}  // namespace

void write_sealed(const std::filesystem::path& path, Wait wait, std::string_view first_line,
                  std::initializer_list<std::string_view> content) {
  Checksum sum;
  sum.add(first_line);
  for (const std::string_view piece : content) sum.add(piece);
  replace_file(path, wait, [&](OutputFile* file) {
    file->write(first_line);
    for (const std::string_view piece : content) file->write(piece);
    file->write(last_line(sum));
  });
}

Seal open_sealed(std::string_view text, std::string_view first_line, std::string_view* content) {
  if (!text.starts_with(first_line)) return Seal::OtherFormat;
  const std::size_t end = text.rfind(last_words);
  if (end == std::string_view::npos || end < first_line.size()) return Seal::Damaged;
  Checksum sum;
  sum.add(text.substr(0, end));
  if (text.substr(end) != last_line(sum)) return Seal::Damaged;
  *content = text.substr(first_line.size(), end - first_line.size());
  return Seal::Sound;
}

}  // namespace tanor::report
