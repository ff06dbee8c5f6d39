#include "report/solution.hpp"

#include "report/friction_parts.hpp"
#include "report/json_writer.hpp"

namespace tanor::report {

namespace {

/// A list of {cause, multipliers, reactions}, in their order; large arrays in files numbered like the list.
void write_causes(JsonWriter* json, const ArrayWriter& arrays, const std::optional<std::vector<ReactionPart>>& parts) {
  json->key("reactions_by_cause");
  if (!parts) {
    json->null();
    return;
  }
  json->begin_array();
  for (std::size_t k = 0; k < parts->size(); ++k) {
    const ReactionPart& part = (*parts)[k];
    ArrayWriter numbered = arrays.with_prefix("cause" + std::to_string(k) + "_");
    json->begin_object();
    json->key("cause").value(part.cause);
    numbered.write_list("multipliers", part.multipliers);
    numbered.write_points("reactions", part.reactions);
    json->end_object();
  }
  json->end_array();
}

void write_members(JsonWriter* json, ArrayWriter arrays, const Solution& solution) {
  json->begin_object();
  arrays.write_points("positions", solution.positions);
  arrays.write_points("velocities", solution.velocities);
  arrays.write_points("accelerations", solution.accelerations);
  arrays.write_points("tangent_accelerations", solution.tangent_accelerations);
  arrays.write_points("normal_accelerations", solution.normal_accelerations);
  json->key("mass_coupling").value(solution.mass_coupling);
  arrays.write_points("tangent_forces", solution.tangent_forces);
  arrays.write_points("normal_forces", solution.normal_forces);
  arrays.write_list("multipliers", solution.multipliers);
  solution.rank ? arrays.write_booleans("multipliers_unique", solution.rank->multipliers_unique)
                : arrays.write_list("multipliers_unique", std::nullopt);
  write_rank(json, solution.rank);
  arrays.write_points("reactions", solution.reactions);
  write_causes(json, arrays, solution.reactions_by_cause);
  arrays.write_points("friction", solution.friction);
  arrays.write_points("tangent_friction", solution.tangent_friction);
  arrays.write_points("normal_friction", solution.normal_friction);
  write_friction_report(json, solution.friction_report);
  arrays.write_points("support_forces", solution.support_forces);
  write_certificate(json, solution.certificate);
  json->key("form").value(solution.form);
  write_left_out(json, solution.left_out);
  json->end_object();
  json->finish();
}

}  // namespace

void print_solution(const Solution& solution) {
  OutputFile file = OutputFile::standard_output();
  JsonWriter json(&file);
  write_members(&json, ArrayWriter(&json), solution);
  file.close();
}

void write_solution(const std::filesystem::path& path, const Solution& solution) {
  const std::filesystem::path prefix = path.parent_path() / (path.stem().string() + "_");
  replace_file(path, [&](OutputFile* file) {
    JsonWriter json(file);
    write_members(&json, ArrayWriter(&json, prefix, solution.num_points), solution);
  });
}

}  // namespace tanor::report
