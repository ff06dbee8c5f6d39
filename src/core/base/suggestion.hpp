#pragma once

#include <algorithm>
#include <numeric>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tanor::detail {

/// Counts the changes that turn one word into the other: letters that are lost, added or replaced, and neighbours that
/// change places (the distance of Damerau and Levenshtein, as an optimal alignment of strings).
inline std::size_t count_changes(std::string_view from, std::string_view to) {
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

/// Returns the only known word that begins as a short form does, up to its last letter: acceleration of acc, velocities
/// of velocity.
inline std::string find_longer_form(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t least = 3;
  std::string found;
  for (const std::string& each : known) {
    const auto same = static_cast<std::size_t>(std::ranges::mismatch(word, each).in1 - word.begin());
    if (same < least || same + 1 < word.size()) continue;
    if (!found.empty()) return "";
    found = each;
  }
  return found;
}

/// Returns the letters and digits of a word, in small letters: tend of t_end and of tEnd.
inline std::string letters_of(std::string_view word) {
  std::string letters;
  for (const char c : word)
    if (c != '_' && c != '-') letters += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return letters;
}

/// Returns the known word that a longer name ends in: step of time_step.
inline std::string find_last_part(std::string_view word, const std::vector<std::string>& known) {
  const auto found = std::ranges::find(known, word.substr(word.rfind('_') + 1));
  return found == known.end() ? "" : *found;
}

/// Returns what the books write for a known word: mu for the coefficient of friction.
inline std::string find_symbol(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::pair<std::string_view, std::string_view> symbols[] = {
      {"mu", "coefficient"},   {"dt", "step"},  {"mu_s", "static_coefficient"},
      {"mu_k", "coefficient"}, {"tol", "rtol"}, {"torque", "moment"}};
  for (const auto& [symbol, name] : symbols)
    if (symbol == word && std::ranges::find(known, name) != known.end()) return std::string(name);
  return "";
}

/// Returns " (did you mean run?)" if a word is near a known one, else nothing.
inline std::string suggest(std::string_view word, const std::vector<std::string>& known) {
  constexpr std::size_t longest = 80;  // of a word that may be a mistyped name
  if (word.size() > longest) return "";
  const auto same = std::ranges::find(known, detail::letters_of(word), detail::letters_of);
  if (same != known.end() && *same != word) return " (did you mean " + *same + "?)";
  const auto near =
      std::ranges::min_element(known, {}, [&](const auto& each) { return detail::count_changes(word, each); });
  const std::size_t changes = near == known.end() ? word.size() : detail::count_changes(word, *near);
  const bool is_near = changes < word.size() && (changes <= std::max<std::size_t>(1, (word.size() + 1) / 4) ||
                                                 std::ranges::is_permutation(word, *near));
  std::string meant = detail::find_symbol(word, known);
  if (meant.empty() && is_near) meant = *near;
  if (meant.empty()) meant = detail::find_longer_form(word, known);
  if (meant.empty()) meant = detail::find_last_part(word, known);
  return meant.empty() ? "" : " (did you mean " + meant + "?)";
}

}  // namespace tanor::detail
