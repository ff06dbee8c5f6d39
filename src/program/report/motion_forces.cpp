#include "report/motion_forces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "report/field_json.hpp"
#include "report/json_text.hpp"

namespace tanor::report {

namespace {

Json describe_sample(double t, const MotionForces& sample) {
  const bool is_found = sample.outcome.ok();
  Json json{{"t", t}};
  for (const auto& [what, violation] : {std::pair{"position", &sample.position},
                                        {"velocity", &sample.velocity},
                                        {"acceleration", &sample.acceleration}}) {
    json[fmt::format("{}_violation", what)] = violation->largest;
    json[fmt::format("{}_violation_at", what)] = json_or_null(violation->where);
  }
  json["largest_control_force"] = is_found ? Json(sample.largest_control) : Json();
  json["largest_control_force_at"] = is_found ? Json("point " + std::to_string(sample.controlled_point)) : Json();
  json["outcome"] = is_found ? "ok" : sample.outcome.what;
  return json;
}

/// Returns one row for each sample. A sample without the array has a row of NaN, which JSON shows as null.
std::vector<double> stack(const ForcesOfMotion& forces, std::vector<double> MotionForces::*array, std::size_t columns) {
  std::vector<double> result;
  result.reserve(forces.samples.size() * columns);
  for (const MotionForces& sample : forces.samples) {
    const std::vector<double>& row = sample.*array;
    result.insert(result.end(), row.begin(), row.end());
    result.resize(result.size() + columns - row.size(), std::numeric_limits<double>::quiet_NaN());
  }
  return result;
}

}  // namespace

void write_forces(const std::filesystem::path& directory, const ForcesOfMotion& forces) {
  make_folder(directory);
  replace_file(directory / forces_name, [&](OutputFile* file) {
    JsonObjectFile json(file);
    const ArrayWriter arrays(&json, forces.units, directory / "forces_", forces.num_points * forces.samples.size());
    json.add("scene", forces.scene);
    json.add("motion", forces.motion);
    json.add("units", json_of(forces.units));
    json.add("given", forces.by_coordinates ? "coordinates" : "positions");
    json.add("points", forces.num_points);
    json.add("groups", forces.groups);
    json.add("equations", forces.num_equations);
    Json samples = Json::array();
    for (std::size_t k = 0; k < forces.samples.size(); ++k)
      samples.push_back(describe_sample(forces.times[k], forces.samples[k]));
    json.add("samples", samples);
    const auto write = [&](std::string_view key, std::vector<double> MotionForces::*array, std::size_t columns) {
      const bool is_known =
          std::ranges::any_of(forces.samples, [&](const MotionForces& sample) { return !(sample.*array).empty(); });
      const std::vector<double> rows = is_known ? stack(forces, array, columns) : std::vector<double>();
      remove_file(directory /
                  fmt::format("forces_{}.npy", key));  // may be left from an earlier motion with more samples
      const bool is_of_points = array != &MotionForces::multipliers;
      arrays.write_rows(key, is_known ? Numbers(rows) : std::nullopt, columns,
                        describe_array({"sample", is_of_points ? "x, y, z of each point" : "equation"},
                                       is_of_points ? forces.units.force : ""));
    };
    write("multipliers", &MotionForces::multipliers, forces.num_equations);
    write("reactions", &MotionForces::reactions, 3 * forces.num_points);
    write("control_forces", &MotionForces::control_forces, 3 * forces.num_points);
    write("support_forces", &MotionForces::support_forces, 3 * forces.num_points);
    write("friction", &MotionForces::friction, 3 * forces.num_points);
    json.finish();
  });
}

}  // namespace tanor::report
