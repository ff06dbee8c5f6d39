#include "scene/text_file.hpp"

#include <algorithm>
#include <cctype>
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

/// First bytes of what holds no lines that can be read here. Those of UTF-32 begin with those of UTF-16.
using namespace std::string_view_literals;
constexpr std::pair<std::string_view, std::string_view> foreign_beginnings[] = {
    {"\x1F\x8B"sv, "a file packed by gzip"},
    {"BZh91AY&SY"sv, "a file packed by bzip2"},
    {"\xFD"
     "7zXZ"sv,
     "a file packed by xz"},
    {"\x28\xB5\x2F\xFD"sv, "a file packed by zstd"},
    {"PK\x03\x04"sv, "a file packed by zip"},
    {"\xFF\xFE\0\0"sv, "a text in UTF-32"},
    {"\0\0\xFE\xFF"sv, "a text in UTF-32"},
    {"\xFF\xFE"sv, "a text in UTF-16"},
    {"\xFE\xFF"sv, "a text in UTF-16"}};

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

std::string ending_of(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending;
}

LineReader::LineReader(std::string name, std::string_view text) : name_(std::move(name)), rest_(text) {
  for (const auto& [beginning, what] : foreign_beginnings)
    if (text.starts_with(beginning))
      throw InputError("", fmt::format("{}: found {}, wanted plain text in ASCII or UTF-8", name_, what));
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  if (text.starts_with(mark)) rest_.remove_prefix(mark.size());
}

bool LineReader::next() {
  if (rest_.empty()) return false;
  ++number_;
  const auto* const end = std::ranges::find_if(rest_, [](char c) { return c == '\n' || c == '\r' || c == '\0'; });
  line_ = rest_.substr(0, static_cast<std::size_t>(end - rest_.begin()));
  rest_.remove_prefix(line_.size());
  if (rest_.starts_with('\0')) complain("found a zero byte, wanted plain text in ASCII or UTF-8");

  const std::size_t length = rest_.starts_with("\n")       ? 1
                             : rest_.starts_with("\r\n")   ? 2
                             : rest_.starts_with("\r\r\n") ? 3
                                                           : 0;
  if (number_ == 1) ends_by_cr_ = !rest_.empty() && length == 0;
  rest_.remove_prefix(length > 0 && !ends_by_cr_ ? length : std::min<std::size_t>(rest_.size(), 1));
  return true;
}

std::string_view LineReader::content() const {
  return trim(line_.substr(0, line_.find('#')));
}

double LineReader::read_number(std::string_view word) const {
  const std::optional<double> number = parse_number(word);
  if (!number) fail(word, "a finite number");
  return *number;
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

bool spells_number(std::string_view word) {
  double number = 0.0;
  return parse_number(word) || std::from_chars(word.data(), word.data() + word.size(), number).ptr == word.end();
}

std::optional<std::int64_t> parse_integer(std::string_view word) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
  if (end != word.data() + word.size() || error != std::errc()) return {};
  return number;
}

}  // namespace tanor::scene
