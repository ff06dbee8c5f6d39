#include "report/observed_words.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.hpp"
#include "report/field_json.hpp"
#include "report/words.hpp"

namespace tanor::report {
using namespace detail;

namespace {

std::string number_with_unit(double number, const std::string& unit) {
  constexpr int digits = 6;
  return with_unit(text(number, digits), unit);
}

/// Returns "12.3 N at t = 0.5 s in links[3]".
std::string describe_extreme(const Extreme& extreme, const std::string& unit, const Units& units) {
  return fmt::format("{} at t = {}{}", number_with_unit(extreme.value, unit),
                     number_with_unit(extreme.time, units.time), extreme.member.empty() ? "" : " in " + extreme.member);
}

std::string describe_part(const Observed& observed, std::size_t part, const Units& units) {
  const Extreme &least = observed.least[part], &largest = observed.largest[part];
  std::string line;
  if (observed.members.empty()) {
    line = number_with_unit(observed.values[part], observed.unit);
    if (!observed.member.empty()) line += " in " + observed.member;
  } else {
    line = text_of_count(observed.members.size(), "number");
  }
  if (std::isnan(least.value) || least.value == largest.value) return line;
  return line + "; least " + describe_extreme(least, observed.unit, units) + ", largest " +
         describe_extreme(largest, observed.unit, units);
}

}  // namespace

std::string format_observables(std::span<const Observed> observables, const Units& units) {
  std::vector<std::pair<std::string, std::string>> lines;
  for (const Observed& each : observables) {
    for (std::size_t part = 0; part < each.least.size(); ++part)
      lines.emplace_back(each.parts.empty() ? each.name : each.name + "." + each.parts[part],
                         describe_part(each, part, units));
  }
  std::size_t width = 0;
  for (const auto& [name, line] : lines) width = std::max(width, name.size());
  std::string result;
  for (const auto& [name, line] : lines) result += fmt::format("  {:{}}  {}\n", name, width, line);
  return result;
}

std::string describe_passage(const Passage& passage, const Units& units) {
  std::string line = passage.member;
  if (passage.energy_lost != 0.0) line += " with " + number_with_unit(passage.energy_lost, units.energy);
  if (!passage.rest.empty()) line += "; " + passage.rest;
  return line;
}

std::string format_passages(std::span<const Passage> passages, const Units& units) {
  constexpr std::size_t most = 10;
  std::string result;
  for (const Passage& each : passages.first(std::min(most, passages.size()))) {
    const std::string line = describe_passage(each, units);
    result += fmt::format("  event at t = {}: {}{}\n", number_with_unit(each.time, units.time), each.name,
                          line.empty() ? "" : ": " + line);
  }
  return result + (passages.size() > most ? fmt::format("  … {} events in all\n", passages.size()) : "");
}

Json describe_observables(std::span<const Observed> observables) {
  constexpr std::size_t many = 1000;
  Json list = Json::array();
  for (const Observed& each : observables) {
    Json object = json_of(each);
    if (each.values.size() > many) {
      object.erase("members");
      object.erase("values");
    }
    list.push_back(std::move(object));
  }
  return list;
}

}  // namespace tanor::report
