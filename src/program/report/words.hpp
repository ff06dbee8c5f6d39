#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "base/with_unit.hpp"

namespace tanor::report {

using detail::with_unit;

/// Formats a number for people, in a format such as "{:.1e}". A number that is not finite becomes a word.
inline std::string in_words(double number, std::string_view format = "{}") {
  if (std::isfinite(number)) return fmt::format(fmt::runtime(format), number);
  if (std::isnan(number)) return "undefined";
  return number > 0.0 ? "infinite" : "-infinite";
}

/// Returns "rad/s" from "rad" and "s", or nothing without letters of the time.
inline std::string per_time(const std::string& what, const std::string& time) {
  return time.empty() ? "" : what + "/" + (time.find(' ') == std::string::npos ? time : "(" + time + ")");
}

/// Returns "1 rod" or "2 rods".
template <class Number>
std::string count_in_words(const Number& number, std::string_view what) {
  const std::string text = fmt::format("{}", number);
  return fmt::format("{} {}{}", text, what, text == "1" ? "" : "s");
}

/// Lists what the scene does not take from its file, then what the computation did not need.
inline std::vector<std::string> list_left_out(std::vector<std::string> of_scene,
                                              const std::vector<std::string>& not_needed) {
  of_scene.insert(of_scene.end(), not_needed.begin(), not_needed.end());
  return of_scene;
}

/// Returns a text in quotes, as a field of CSV (RFC 4180), on one line.
inline std::string quote_csv(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c == '\n' ? ' ' : c);
  return quoted + "\"";
}

/// Returns a text in which nothing is markup of XML.
inline std::string escape_xml(std::string_view text) {
  std::string result;
  for (const char c : text)
    result += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

}  // namespace tanor::report
