#include "scene/suggestion.hpp"

#include <algorithm>
#include <numeric>
#include <string_view>
#include <utility>

namespace tanor::scene {

namespace {

/// Counts the changes that turn one word into the other: letters that are lost, added or replaced, and neighbours that
/// change places (the distance of Damerau and Levenshtein, as an optimal alignment of strings).
std::size_t count_changes(std::string_view from, std::string_view to) {
  std::vector<std::size_t> row(to.size() + 1), before, before_that;
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= from.size(); ++i) {
    before_that = std::exchange(before, row);
    row[0] = i;
    for (std::size_t k = 1; k <= to.size(); ++k) {
      const bool is_swapped = i > 1 && k > 1 && from[i - 1] == to[k - 2] && from[i - 2] == to[k - 1];
      row[k] = std::min({before[k - 1] + (from[i - 1] == to[k - 1] ? 0 : 1), before[k] + 1, row[k - 1] + 1});
      if (is_swapped) row[k] = std::min(row[k], before_that[k - 2] + 1);
    }
  }
  return row.back();
}

}  // namespace

std::string suggest(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t longest = 80;  // of a word that may be a mistyped name
  if (word.size() > longest) return "";
  const auto near = std::ranges::min_element(known, {}, [&](const auto& each) { return count_changes(word, each); });
  const std::size_t changes = near == known.end() ? word.size() : count_changes(word, *near);
  const bool is_near = changes < word.size() && changes <= std::max<std::size_t>(1, (word.size() + 1) / 4);
  return is_near ? " (did you mean " + *near + "?)" : "";
}

}  // namespace tanor::scene
