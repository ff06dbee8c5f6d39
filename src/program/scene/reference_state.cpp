#include "scene/reference_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string_view>

#include <tanor/error.hpp>

#include "base/text.hpp"
#include "scene/cursor.hpp"
#include "scene/document.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
using namespace detail;

namespace {

/// Positions x y z, one after the other, at one time.
struct Instant {
  double t = 0.0;
  std::vector<double> places;
};

std::vector<Instant> read_blocks(const std::string& name, const std::string& text) {
  std::vector<Instant> instants;
  std::size_t columns = 0;  // of the earlier lines in this block
  LineReader lines(name, text);
  while (lines.next()) {
    if (lines.content().empty()) continue;
    std::vector<double> numbers;
    for (const std::string_view word : split_words(lines.content())) numbers.push_back(lines.read_number(word));
    if (numbers.size() == 1) {
      instants.push_back({numbers[0], {}});
      columns = 0;
    } else if (instants.empty() || (numbers.size() != 3 && numbers.size() != 6)) {
      lines.complain("wanted a time, s, alone on its line, then x y z or x y z vx vy vz a line");
    } else if (columns != 0 && columns != numbers.size()) {
      lines.complain(fmt::format("found {} numbers, wanted {} as in the line before", numbers.size(), columns));
    } else {
      columns = numbers.size();
      instants.back().places.insert(instants.back().places.end(), numbers.begin(), numbers.begin() + 3);
    }
  }
  return instants;
}

/// Reads a number, or a text that contains one.
double read_number(const Cursor& value) {
  if (!value.is_string()) return value.number();
  const auto number = parse_number(value.string());
  if (!number) value.fail("a finite number");
  return *number;
}

std::vector<Instant> read_case(const std::string& name, const std::string& text) {
  const Document document(text, name);
  const Cursor file(document);
  if (!file.is_object()) file.fail("an object with a trajectory");
  const std::int64_t dimension = file["dim"].integer(2, 3, 3);
  std::vector<Instant> instants;
  for (const Cursor& entry : file["trajectory"].list("a list of instants {\"t\": …, \"r\": […]}")) {
    if (!entry.is_object()) entry.fail("an instant {\"t\": …, \"r\": […]}");
    Instant& instant = instants.emplace_back(Instant{read_number(entry["t"]), {}});
    const Cursor& places = entry["r"];
    std::int64_t axis = 0;
    for (const Cursor& coordinate : places.list("a list of numbers, point by point")) {
      instant.places.push_back(read_number(coordinate));
      if (++axis < dimension) continue;
      if (dimension == 2) instant.places.push_back(0.0);
      axis = 0;
    }
    if (axis != 0) {
      places.complain(fmt::format("found {}, wanted {} for each point", text_of_count(places.list("").size(), "number"),
                                  dimension));
    }
  }
  return instants;
}

std::vector<Index> list_movable(const System& system) {
  std::vector<char> is_support(system.masses.size(), 0);
  for (const Support& support : system.supports) {
    for (const Index point : support.points) is_support[static_cast<std::size_t>(point)] = 1;
  }
  std::vector<Index> movable;
  for (std::size_t i = 0; i < is_support.size(); ++i) {
    if (!is_support[i]) movable.push_back(static_cast<Index>(i));
  }
  return movable;
}

}  // namespace

ReferenceState read_reference_state(const std::filesystem::path& file, const System& system, double t) {
  const std::string text = read_text(file), name = file.filename().string();
  constexpr int most_named = 10;
  std::string times;
  int count = 0;
  for (const Instant& instant : ending_of(file) == ".json" ? read_case(name, text) : read_blocks(name, text)) {
    if (++count <= most_named) times += fmt::format("{}{}", times.empty() ? "" : ", ", detail::text(instant.t));
    if (std::abs(instant.t - t) > 1e-12 * std::abs(t)) continue;
    ReferenceState state{name, list_movable(system), std::vector<double>(system.positions.size(), 0.0)};
    const std::size_t found = instant.places.size() / 3, all = system.masses.size();
    if (found == all) {
      state.points.clear();
      for (std::size_t i = 0; i < all; ++i) state.points.push_back(static_cast<Index>(i));
    }
    if (found != state.points.size()) {
      throw InputError(name, fmt::format("has {} points at t = {}; the scene has {}, {} without supports", found,
                                         detail::text(t), all, state.points.size()));
    }
    for (std::size_t k = 0; k < found; ++k) {
      std::copy_n(&instant.places[3 * k], 3, &state.positions[3 * static_cast<std::size_t>(state.points[k])]);
    }
    return state;
  }
  if (count > most_named) times += fmt::format(", … ({} in all)", count);
  throw InputError(
      name, fmt::format("has no state at t_end = {}; its times are {}", detail::text(t), count > 0 ? times : "none"));
}

}  // namespace tanor::scene
