#pragma once

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "folder.hpp"
#include "scene/scene.hpp"

namespace tanor::scene {

/// Reads a scene whose relative paths lead to the fixtures.
inline Scene parse(const std::string& text) {
  return parse_scene(text, TANOR_TEST_DATA "/scene.json");
}

/// Reads a scene that has nothing but the file that is imported with these keys.
inline Scene import(const std::string& keys) {
  return parse(R"({"tanor_scene": 1, "import": {)" + keys + "}}");
}

/// Returns the rods that "generate" and "import" make.
inline const Rods& rods_of(const Scene& scene) {
  return std::get<Rods>(scene.system.constraints.at(0));
}

/// Returns what the program would print behind "tanor: ", with the bare file name.
inline std::string error_of(const std::string& text, const std::filesystem::path& file = "scene.json") {
  try {
    parse_scene(text, file);
  } catch (const InputError& error) {
    const std::string folder = file.has_parent_path() ? file.parent_path().string() + "/" : "";
    return error.where().substr(folder.size()) + ": " + error.what();
  }
  return "no error";
}

/// Reads a scene that imports a file of this content, with more keys.
inline Scene import_text(const std::string& name, const std::string& text, const std::string& keys = "") {
  const Folder folder;
  folder.add(name, text);
  return parse_scene(R"({"tanor_scene": 1, "import": {"file": ")" + name + "\"" + keys + "}}", folder / "s.json");
}
/// Returns what the program would print about such a scene.
inline std::string import_error(const std::string& name, const std::string& text, const std::string& keys = "") {
  const Folder folder;
  folder.add(name, text);
  return error_of(R"({"tanor_scene": 1, "import": {"file": ")" + name + "\"" + keys + "}}", folder / "s.json");
}

/// Returns a scene of three points a metre apart on the x axis, with more keys.
inline std::string three_points(const std::string& more = "") {
  return R"({"tanor_scene": 1, "points": {"positions": [[0,0,0],[1,0,0],[2,0,0]]})" +
         (more.empty() ? "" : ", " + more) + "}";
}

/// Returns the value of a vector at time t.
inline Vector3 at(const VectorFunction& function, double t) {
  const auto jets = function(t);
  return {jets[0].value(), jets[1].value(), jets[2].value()};
}

/// Returns the length of a rod at the start.
inline double rod_length(const System& system, const Rods& rods, std::size_t k) {
  const auto [i, j] = rods.pairs[k];
  double square = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double shift = rods.offsets.empty() ? 0.0 : rods.offsets[k][axis];
    const double d = system.positions[3 * static_cast<std::size_t>(j) + axis] -
                     system.positions[3 * static_cast<std::size_t>(i) + axis] + shift;
    square += d * d;
  }
  return std::sqrt(square);
}

}  // namespace tanor::scene
