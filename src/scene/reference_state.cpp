#include "scene/reference_state.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include <tanor/error.hpp>

#include "scene/text_file.hpp"

namespace tanor::scene {

namespace {

/// x y z, one after the other, at a time.
struct Instant {
  double t = 0.0;
  std::vector<double> places;
};

std::vector<Instant> read_blocks(const std::string& name, const std::string& text) {
  std::vector<Instant> instants;
  LineReader lines(name, text);
  while (lines.next()) {
    const std::string_view line = trim(lines.line().substr(0, lines.line().find('#')));
    if (line.empty()) continue;
    std::vector<double> numbers;
    for (const std::string_view word : split_words(line)) {
      const auto number = parse_number(word);
      if (!number) lines.fail(word, "a finite number");
      numbers.push_back(*number);
    }
    if (numbers.size() == 1) {
      instants.push_back({numbers[0], {}});
    } else if (instants.empty() || (numbers.size() != 3 && numbers.size() != 6)) {
      lines.complain("wanted a time, s, alone on its line, then x y z or x y z vx vy vz a line");
    } else {
      instants.back().places.insert(instants.back().places.end(), numbers.begin(), numbers.begin() + 3);
    }
  }
  return instants;
}

std::vector<Instant> read_case(const std::string& name, const std::string& text) {
  const auto number = [](const nlohmann::json& value) {
    return value.is_string() ? std::stod(value.get<std::string>()) : value.get<double>();
  };
  std::vector<Instant> instants;
  try {
    const nlohmann::json file = nlohmann::json::parse(text);
    const std::size_t dimension = file.value("dim", std::size_t{3});
    for (const nlohmann::json& entry : file.at("trajectory")) {
      Instant& instant = instants.emplace_back(Instant{number(entry.at("t")), {}});
      const nlohmann::json& r = entry.at("r");
      for (std::size_t i = 0; i < r.size(); i += dimension) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          instant.places.push_back(axis < dimension ? number(r.at(i + axis)) : 0.0);
        }
      }
    }
  } catch (const std::exception& error) {  // of the JSON reader, or of stod
    throw InputError(name, fmt::format("is no case with a trajectory of t and r: {}", error.what()));
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
  std::string times;
  for (const Instant& instant : file.extension() == ".json" ? read_case(name, text) : read_blocks(name, text)) {
    times += fmt::format("{}{:g}", times.empty() ? "" : ", ", instant.t);
    if (std::abs(instant.t - t) > 1e-12 * t) continue;
    ReferenceState state{name, list_movable(system), std::vector<double>(system.positions.size(), 0.0)};
    const std::size_t found = instant.places.size() / 3, all = system.masses.size();
    if (found == all) {
      state.points.clear();
      for (std::size_t i = 0; i < all; ++i) state.points.push_back(static_cast<Index>(i));
    }
    if (found != state.points.size()) {
      throw InputError(name, fmt::format("has {} points at t = {:g} s; the scene has {}, {} without supports", found, t,
                                         all, state.points.size()));
    }
    for (std::size_t k = 0; k < found; ++k) {
      std::copy_n(&instant.places[3 * k], 3, &state.positions[3 * static_cast<std::size_t>(state.points[k])]);
    }
    return state;
  }
  throw InputError(name, fmt::format("has no state at t_end = {:g} s; its times are {}", t, times));
}

}  // namespace tanor::scene
