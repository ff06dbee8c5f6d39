#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace tanor::cases {

/// The numbers of a case at one time. Plane vectors get z = 0. The multipliers belong to the case's own constraint
/// functions.
struct Instant {
  double t = 0.0;
  std::vector<double> r, v, w;  // [3 * masses]
  std::vector<double> lambda;   // [equations]; empty where the case names none
  std::optional<double> energy;
};

inline std::filesystem::path reference_folder() {
  return std::filesystem::path(TANOR_SOURCE_DIR) / "tests/cases/reference";
}

/// Reads a case; `name` has no ".json".
inline nlohmann::json read_case(const std::string& name) {
  return nlohmann::json::parse(std::ifstream(reference_folder() / (name + ".json")));
}

/// Returns a number of a case, which is printed as text with 28 digits.
inline double number(const nlohmann::json& text) {
  return std::strtod(text.get_ref<const std::string&>().c_str(), nullptr);
}

inline std::vector<double> numbers(const nlohmann::json& list) {
  std::vector<double> result;
  for (const nlohmann::json& text : list) result.push_back(number(text));
  return result;
}

/// Turns numbers of `dimension` a point into 3 a point.
inline std::vector<double> make_spatial(const std::vector<double>& flat, std::size_t dimension) {
  std::vector<double> result;
  for (std::size_t i = 0; i < flat.size(); i += dimension) {
    for (std::size_t axis = 0; axis < 3; ++axis) result.push_back(axis < dimension ? flat[i + axis] : 0.0);
  }
  return result;
}

/// Reads the times of a case, the start first. The car axis lists them under "ours".
inline std::vector<Instant> read_trajectory(const std::string& name) {
  const nlohmann::json file = read_case(name);
  const std::size_t dimension = file.value("dim", std::size_t{2});
  std::vector<Instant> result;
  for (const nlohmann::json& entry : file.at(file.contains("ours") ? "ours" : "trajectory")) {
    const auto vectors = [&](const char* key) { return make_spatial(numbers(entry.at(key)), dimension); };
    result.push_back({number(entry.at("t")), vectors("r"), vectors("v"), vectors("w"), {}, {}});
    if (entry.contains("lambda")) result.back().lambda = numbers(entry.at("lambda"));
    if (entry.contains("energy")) result.back().energy = number(entry.at("energy"));
  }
  return result;
}

}  // namespace tanor::cases
