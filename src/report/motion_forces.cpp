#include "report/motion_forces.hpp"

#include <algorithm>
#include <limits>

#include "report/array_writer.hpp"
#include "report/json_writer.hpp"

namespace tanor::report {

namespace {

void write_violation(JsonWriter* json, const std::string& level, const Violation& violation) {
  json->key(level + "_violation").value(violation.largest);
  json->key(level + "_violation_at");
  violation.where.empty() ? json->null() : json->value(violation.where);
}

void write_sample(JsonWriter* json, double t, const MotionForces& sample) {
  json->begin_object();
  json->key("t").value(t);
  write_violation(json, "position", sample.position);
  write_violation(json, "velocity", sample.velocity);
  write_violation(json, "acceleration", sample.acceleration);
  json->key("largest_control_force");
  sample.outcome.ok() ? json->value(sample.largest_control) : json->null();
  json->key("largest_control_force_at");
  sample.outcome.ok() ? json->value("point " + std::to_string(sample.controlled_point)) : json->null();
  json->key("outcome");
  sample.outcome.ok() ? json->value("ok") : json->value(sample.outcome.what);
  json->end_object();
}

/// One row a sample; where a sample has none: NaN, which JSON shows as null.
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
  replace_file(directory / "forces.json", [&](OutputFile* file) {
    JsonWriter json(file);
    ArrayWriter arrays(&json, directory / "forces_", forces.num_points * forces.samples.size());
    json.begin_object();
    json.key("scene").value(forces.scene);
    json.key("motion").value(forces.motion);
    json.key("given").value(forces.by_coordinates ? "coordinates" : "positions");
    json.key("points").value(forces.num_points);
    json.key("equations").value(forces.num_equations);
    json.key("samples").begin_array();
    for (std::size_t k = 0; k < forces.samples.size(); ++k) write_sample(&json, forces.times[k], forces.samples[k]);
    json.end_array();
    const auto write = [&](std::string_view key, std::vector<double> MotionForces::*array, std::size_t columns) {
      const bool is_known =
          std::ranges::any_of(forces.samples, [&](const MotionForces& sample) { return !(sample.*array).empty(); });
      if (!is_known) return arrays.write_rows(key, std::nullopt, columns);
      const std::vector<double> rows = stack(forces, array, columns);
      arrays.write_rows(key, rows, columns);
    };
    write("multipliers", &MotionForces::multipliers, forces.num_equations);
    write("reactions", &MotionForces::reactions, 3 * forces.num_points);
    write("control_forces", &MotionForces::control_forces, 3 * forces.num_points);
    write("support_forces", &MotionForces::support_forces, 3 * forces.num_points);
    write("friction", &MotionForces::friction, 3 * forces.num_points);
    json.end_object();
    json.finish();
  });
}

}  // namespace tanor::report
