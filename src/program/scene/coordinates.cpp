#include <algorithm>

#include <fmt/format.h>

#include "scene/kind.hpp"

namespace tanor::scene {
namespace {

/// Reads the numbers of the named coordinates, in the order of the names; missing ones are 0.
std::vector<double> read_rates(const Cursor& rates, const std::vector<std::string>& names) {
  std::vector<double> result(names.size(), 0.0);
  if (!rates) return result;
  for (const auto& [name, rate] : rates.members("an object of numbers, as q")) {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end()) {
      std::vector<std::string> quoted(names.size());
      std::transform(names.begin(), names.end(), quoted.begin(), quote);
      rate.fail(fmt::format("a coordinate of q, one of {}", fmt::join(quoted, ", ")));
    }
    result[static_cast<std::size_t>(found - names.begin())] = rate.number();
  }
  return result;
}

/// Reads one text for each point. A single text belongs to the only point, and a missing one is "0".
std::vector<std::string> read_texts(const Cursor& axis, std::size_t num_points) {
  if (!axis) return std::vector<std::string>(num_points, "0");
  if (axis.is_string() && num_points == 1) return {axis.string()};
  std::vector<std::string> texts;
  const std::string wanted =
      num_points == 1 ? "a formula" : fmt::format("a list of {} formulas, one a point", num_points);
  for (const Cursor text : axis.list(wanted)) texts.push_back(text.string());
  if (texts.size() != num_points) axis.fail(wanted);
  return texts;
}

}  // namespace

template <>
struct Extra<ChainAngles> {
  static void read(const Cursor& entry, const Context&, ChainAngles* chain) {
    const Cursor normal = entry["normal"];
    if (normal && chain->normal == Vector3{})
      normal.fail("a normal that is not zero; without one directions are spatial");
  }
};

template <>
struct Extra<UserCoordinates> {
  static constexpr std::array<std::string_view, 7> keys{"name", "points", "q", "q_dot", "x", "y", "z"};
  static constexpr bool read_alone = true;
  static void read(const Cursor& entry, const Context& context, UserCoordinates* user) {
    user->tuples = {context.points(entry["points"])};
    const std::size_t num_points = user->tuples[0].size();
    if (num_points == 0) entry["points"].fail("at least one point");

    std::vector<std::string> names;
    for (const auto& [name, value] : entry["q"].members("an object of numbers: the coordinates at the start")) {
      names.emplace_back(name);
      user->q.push_back(value.number());
    }
    user->q_dot = read_rates(entry["q_dot"], names);

    constexpr std::array axes = {"x", "y", "z"};
    std::vector<std::string> components(3 * num_points);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::vector<std::string> texts = read_texts(entry[axes[axis]], num_points);
      for (std::size_t p = 0; p < num_points; ++p) components[3 * p + axis] = texts[p];
    }
    try {
      user->kernel = formula_coordinates(names, components, context.parameters);
    } catch (const InputError& error) {
      if (error.where().empty()) entry["q"].complain(error.what());
      // "/<component>": the text of an axis of a point
      const std::size_t component = std::stoul(error.where().substr(1));
      const Cursor axis = entry[axes[component % 3]];
      (axis.is_list() ? axis.follow(std::to_string(component / 3)) : axis).complain(error.what());
    }
  }
};

template std::vector<Coordinates> read_entries(const Cursor&, std::string_view, const Context&);

}  // namespace tanor::scene
