#include "report/solution.hpp"

#include "report/field_json.hpp"
#include "report/json_text.hpp"
#include "report/page.hpp"
#include "report/shared_parts.hpp"

namespace tanor::report {

namespace {

/// Writes a list of {cause, multipliers, reactions} in their order. The files of large arrays are numbered like the
/// list.
void write_causes(const ArrayWriter& arrays, const std::optional<std::vector<ReactionPart>>& parts,
                  JsonObjectFile* json) {
  constexpr std::string_view key = "reactions_by_cause";
  if (!parts) return json->add(key, {});
  json->begin_list(key);
  for (std::size_t k = 0; k < parts->size(); ++k) {
    const ReactionPart& part = (*parts)[k];
    const ArrayWriter numbered = arrays.with_prefix("cause" + std::to_string(k) + "_");
    json->begin_object();
    json->add("cause", part.cause);
    numbered.write_list("multipliers", part.multipliers);
    numbered.write_points("reactions", Dimension::Forces, part.reactions);
    json->end();
  }
  json->end();
}

void write_members(const ArrayWriter& arrays, const Solution& solution, JsonObjectFile* json) {
  const auto part = [&](std::vector<double> Split::*which) {
    return solution.split ? Numbers((*solution.split).*which) : std::nullopt;
  };
  const auto friction = [&](std::vector<double> Split::*which) {
    return solution.friction ? part(which) : std::nullopt;
  };
  json->add("units", json_of(solution.units));
  json->add("observables", describe_observables(solution.observed));
  arrays.write_points("positions", Dimension::Length, solution.positions);
  arrays.write_points("velocities", Dimension::Velocity, solution.velocities);
  arrays.write_points("accelerations", Dimension::Acceleration, solution.accelerations);
  arrays.write_points("tangent_accelerations", Dimension::Acceleration, part(&Split::tangent_accelerations));
  arrays.write_points("normal_accelerations", Dimension::Acceleration, part(&Split::normal_accelerations));
  json->add("mass_coupling", solution.split ? Json(solution.split->mass_coupling) : Json());
  arrays.write_points("tangent_forces", Dimension::Forces, part(&Split::tangent_forces));
  arrays.write_points("normal_forces", Dimension::Forces, part(&Split::normal_forces));
  json->add("groups", solution.groups);
  arrays.write_list("multipliers", solution.multipliers);
  arrays.write_booleans("multipliers_unique",
                        solution.rank ? std::optional(solution.rank->multipliers_unique) : std::nullopt);
  json->add_members(describe_rank(solution.rank));
  arrays.write_list("self_stress", solution.self_stress);
  arrays.write_points("reactions", Dimension::Forces, solution.reactions);
  write_causes(arrays, solution.reactions_by_cause, json);
  arrays.write_points("friction", Dimension::Forces, solution.friction);
  arrays.write_points("tangent_friction", Dimension::Forces, friction(&Split::tangent_friction));
  arrays.write_points("normal_friction", Dimension::Forces, friction(&Split::normal_friction));
  json->add("friction_report", describe_friction_report(solution.friction_report));
  arrays.write_points("support_forces", Dimension::Forces, solution.support_forces);
  json->add("certificate", describe_certificate(solution.certificate));
  json->add("form", solution.form);
  json->add("left_out", solution.left_out);
  json->finish();
}

}  // namespace

void print_solution(const Solution& solution) {
  OutputFile file = OutputFile::standard_output();
  JsonObjectFile json(&file);
  write_members(ArrayWriter(&json), solution, &json);
  file.close();
}

void write_solution(const std::filesystem::path& path, const Solution& solution) {
  const std::filesystem::path prefix = path.parent_path() / (path.stem().string() + "_");
  replace_file(path, [&](OutputFile* file) {
    JsonObjectFile json(file);
    write_members(ArrayWriter(&json, solution.units, prefix, solution.num_points), solution, &json);
  });
}

}  // namespace tanor::report
