#include "report/solution.hpp"

#include "report/friction_parts.hpp"
#include "report/json_text.hpp"

namespace tanor::report {

namespace {

/// A list of {cause, multipliers, reactions}, in their order; large arrays in files numbered like the list.
Json describe_causes(const ArrayWriter& arrays, const std::optional<std::vector<ReactionPart>>& parts) {
  if (!parts) return {};
  Json list = Json::array();
  for (const ReactionPart& part : *parts) {
    const ArrayWriter numbered = arrays.with_prefix("cause" + std::to_string(list.size()) + "_");
    list.push_back({{"cause", part.cause},
                    {"multipliers", numbered.write_list("multipliers", part.multipliers)},
                    {"reactions", numbered.write_points("reactions", part.reactions)}});
  }
  return list;
}

void write_members(OutputFile* file, const ArrayWriter& arrays, const Solution& solution) {
  JsonObjectFile json(file);
  const auto add_points = [&](std::string_view key, const Numbers& numbers) {
    json.add(key, arrays.write_points(key, numbers));
  };
  add_points("positions", solution.positions);
  add_points("velocities", solution.velocities);
  add_points("accelerations", solution.accelerations);
  add_points("tangent_accelerations", solution.tangent_accelerations);
  add_points("normal_accelerations", solution.normal_accelerations);
  json.add("mass_coupling", json_or_null(solution.mass_coupling));
  add_points("tangent_forces", solution.tangent_forces);
  add_points("normal_forces", solution.normal_forces);
  json.add("multipliers", arrays.write_list("multipliers", solution.multipliers));
  json.add("multipliers_unique",
           solution.rank ? arrays.write_booleans("multipliers_unique", solution.rank->multipliers_unique) : Json());
  add_rank(solution.rank, &json);
  add_points("reactions", solution.reactions);
  json.add("reactions_by_cause", describe_causes(arrays, solution.reactions_by_cause));
  add_points("friction", solution.friction);
  add_points("tangent_friction", solution.tangent_friction);
  add_points("normal_friction", solution.normal_friction);
  json.add("friction_report", describe_friction_report(solution.friction_report));
  add_points("support_forces", solution.support_forces);
  json.add("certificate", describe_certificate(solution.certificate));
  json.add("form", solution.form);
  json.add("left_out", solution.left_out);
  json.finish();
}

}  // namespace

void print_solution(const Solution& solution) {
  OutputFile file = OutputFile::standard_output();
  write_members(&file, ArrayWriter(), solution);
  file.close();
}

void write_solution(const std::filesystem::path& path, const Solution& solution) {
  const std::filesystem::path prefix = path.parent_path() / (path.stem().string() + "_");
  replace_file(path,
               [&](OutputFile* file) { write_members(file, ArrayWriter(prefix, solution.num_points), solution); });
}

}  // namespace tanor::report
