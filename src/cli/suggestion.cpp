#include "cli/suggestion.hpp"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>

namespace tanor::cli {

namespace {

/// Counts the changes of single letters that turn one word into the other (Levenshtein).
std::size_t count_changes(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < from.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i + 1);
    for (std::size_t k = 0; k < to.size(); ++k) {
      const std::size_t replaced = diagonal + (from[i] == to[k] ? 0 : 1);
      diagonal = row[k + 1];
      row[k + 1] = std::min({replaced, diagonal + 1, row[k] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::string suggest(const std::string& word, const std::vector<std::string>& known) {
  const auto near = std::ranges::min_element(known, {}, [&](const auto& each) { return count_changes(word, each); });
  const bool is_near = near != known.end() && count_changes(word, *near) <= 1 + (word.size() + 1) / 4;
  return is_near ? " (did you mean " + *near + "?)" : "";
}

}  // namespace tanor::cli
