#include "scene/text_file.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <system_error>

#include <fmt/format.h>

#include <tanor/error.hpp>

#include "scene/document.hpp"

namespace tanor::scene {
namespace {

constexpr std::string_view blanks = " \t\r\f\v";
constexpr std::size_t most_of_a_stream = std::size_t{1} << 30;

}  // namespace

std::string read_text(const std::filesystem::path& file) {
  errno = 0;
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  char part[1 << 16];
  // A name may be too long for any file, and a device or pipe may have no end.
  std::error_code unnamed;
  const bool may_be_endless = !std::filesystem::is_regular_file(file, unnamed);
  while (stream.read(part, sizeof part), stream.gcount() > 0) {
    text.append(part, static_cast<std::size_t>(stream.gcount()));
    if (may_be_endless && text.size() > most_of_a_stream)
      throw InputError("", fmt::format("{} cannot be read: it is no file and has more than {} MiB", file.string(),
                                       most_of_a_stream >> 20));
  }
  if (!stream.eof())
    throw InputError(
        "", fmt::format("{} cannot be read: {}", cut(file.string(), 300), std::generic_category().message(errno)));
  return text;
}

bool LineReader::next() {
  if (rest_.empty()) return false;
  const std::size_t end = rest_.find('\n');
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(end == std::string_view::npos ? rest_.size() : end + 1);
  if (line_.ends_with('\r')) line_.remove_suffix(1);
  ++number_;
  return true;
}

void LineReader::fail(std::string_view found, std::string_view wanted) const {
  complain(fmt::format("found {}, wanted {}", quote(found), wanted));
}

void LineReader::complain(std::string_view what) const {
  throw InputError("", fmt::format("{}, line {}: {}", name_, number_, what));
}

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(blanks) + 1 - first);
}

std::string_view columns(std::string_view line, std::size_t first, std::size_t last) {
  if (line.size() < first) return {};
  return trim(line.substr(first - 1, last + 1 - first));
}

std::vector<std::string_view> split_words(std::string_view line) {
  std::vector<std::string_view> words;
  for (line = trim(line); !line.empty(); line = trim(line)) {
    words.push_back(line.substr(0, line.find_first_of(blanks)));
    line.remove_prefix(words.back().size());
  }
  return words;
}

std::optional<double> parse_number(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (end != word.data() + word.size() || error == std::errc::invalid_argument) return {};
  // from_chars does not distinguish 1e999 from 1e-999; strtod does.
  if (error == std::errc::result_out_of_range) number = std::strtod(std::string(word).c_str(), nullptr);
  if (!std::isfinite(number)) return {};
  return number;
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (end != word.data() + word.size() || error != std::errc()) return {};
  return number;
}

}  // namespace tanor::scene
