#include "report/equilibrium.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include <tanor/enum_names.hpp>
#include <tanor/statics_names.hpp>

#include "report/field_json.hpp"
#include "report/guides.hpp"
#include "report/modes.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/shared_parts.hpp"
#include "report/shown_parts.hpp"
#include "report/starting_places.hpp"
#include "report/text_formats.hpp"
#include "report/vtp_frame.hpp"
#include "system/members.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

Json describe(const EquilibriumResult& found) {
  const StabilityReport& stability = found.stability;
  const bool is_known = stability.status != Stability::None;
  const bool knows_energy = is_known && stability.status != Stability::NotConservative;
  Json json = known_if(knows_energy, json_of(stability), "unstable_directions", "zero_modes", "rigid_zero_modes");
  json["accepted"] = found.outcome.ok();
  json["why"] = json_of(found.outcome.what);
  json.update(json_of(found.search));
  using E = EquilibriumResult;
  json.update(json_of_members<&E::residual_force, &E::largest_force, &E::violation, &E::energy, &E::self_stress_states,
                              &E::dependences, &E::buckling_load_factor>(found));
  json["multipliers_unique"] = std::ranges::all_of(found.multipliers_unique, std::identity{});
  return json;
}

/// Returns for each one-sided group the members that carry force.
Json describe_one_sided(const scene::Scene& scene, const EquilibriumResult& found) {
  Json json = Json::object();
  for_each_group(scene.system, [&](const std::string& name, std::size_t group, std::size_t row, std::size_t members) {
    const auto is_it = [&](const OneSided& each) { return each.constraint == name; };
    const bool has_side = std::visit(
        [](const auto& each) {
          if constexpr (requires { each.side; }) return each.side.has_value();
          return false;
        },
        scene.system.constraints[group]);
    if (!has_side && std::ranges::none_of(scene.equilibrium.one_sided, is_it)) return;
    Json closed = Json::array();
    for (std::size_t k = 0; k < members; ++k) {
      if (!found.open[row + k]) closed.push_back(k);
    }
    json[name] = {{"closed", std::move(closed)}, {"members", members}};
  });
  return json;
}

void write_summary(const fs::path& directory, const scene::Scene& scene, const EquilibriumResult& found,
                   std::span<const Observed> observed, const std::optional<Modes>& modes) {
  replace_file(directory / "summary.json", [&](OutputFile* file) {
    JsonObjectFile json(file);
    json.add_members(describe_head(scene.name, scene.source, scene.system.units, observed));
    json.add("points", scene.system.num_points());
    json.add("equations", found.multipliers.size());
    json.add("groups", list_groups(scene.system));
    json.add("equilibrium", describe(found));
    if (!found.open.empty()) json.add("one_sided", describe_one_sided(scene, found));
    add_modes(directory, scene.system.units, modes, &json);
    const ArrayWriter arrays(&json, scene.system.units, directory / "final_", scene.system.num_points());
    json.begin_object("final");
    arrays.write_points("positions", Dimension::Length, found.positions);
    arrays.write_list("multipliers", found.multipliers);
    arrays.write_list("self_stress", found.self_stress.empty() ? std::nullopt : Numbers(found.self_stress));
    arrays.write_points("reactions", Dimension::Forces, found.reactions);
    arrays.write_points("support_forces", Dimension::Forces, found.support_forces);
    const std::vector<double>& shape = found.stability.lowest_shape;
    arrays.write_rows("lowest_shape", shape.empty() ? std::nullopt : Numbers(shape), 3,
                      describe_array({"point", "x, y, z"}, unit_of_shapes(scene.system.units)));
    json.end();
    json.add("left_out", found.left_out);
    json.finish();
  });
}

/// Makes the paths of files in the scene absolute, so that the new scene finds them.
void make_paths_absolute(const fs::path& directory, Json* json) {
  for (auto& [key, value] : json->items()) {
    if (value.is_structured())
      make_paths_absolute(directory, &value);
    else if (value.is_string() && (key == "file" || key == "table"))
      value = fs::absolute(directory / value.get<std::string>()).lexically_normal().string();
  }
}

/// Returns a group of bonds, bendings or torsions as an entry of "forces".
template <HasEnergy Group>
Json energy_as_json(const Group& group) {
  Json json = {{"name", group.name},
               {"kind", KindOf<Group>::name},
               {"law", name_of(group.law)},
               {list_name<Group>(), group.*KindOf<Group>::members}};
  for (const LawNumber& number : KindOf<Group>::law_numbers(group)) {
    const std::vector<double>& all = number.value->constants;
    json[number.name] = all.size() == 1 ? Json(all[0]) : Json(all);
  }
  if constexpr (std::is_same_v<Group, Torsions>) {
    if (!group.coefficients.empty()) json["coefficients"] = group.coefficients;
    if (group.law == TorsionLaw::Periodic) json["multiplicity"] = group.multiplicity;
  }
  return json;
}

/// Writes the supports, rods, angles and energies that came with generated or imported points into the scene. In the
/// system such supports and constraints come first, and energies last. All constraints get the names that they have in
/// the system.
void write_what_came_with_points(const System& system, Json* json) {
  const auto own = [&](const char* key, std::size_t all) {
    return all - (json->contains(key) ? (*json)[key].size() : 0);
  };
  Json supports = Json::array(), constraints = Json::array();
  for (std::size_t k = 0; k < own("supports", system.supports.size()); ++k)
    supports.push_back({{"points", system.supports[k].points}});
  for (std::size_t k = 0; k < own("constraints", system.constraints.size()); ++k) {
    if (const auto* rods = std::get_if<Rods>(&system.constraints[k])) {
      constraints.push_back({{"kind", "rod"}, {"pairs", rods->pairs}});
      if (!rods->length.constants.empty()) constraints.back()["length"] = rods->length.constants;
      if (!rods->offsets.empty()) constraints.back()["offsets"] = rods->offsets;
    } else if (const auto* angles = std::get_if<Angles>(&system.constraints[k])) {
      constraints.push_back({{"kind", "angle"}, {"triples", angles->triples}});
    }
  }
  for (const auto& [key, list] : {std::pair{"supports", &supports}, {"constraints", &constraints}}) {
    if (json->contains(key)) {
      for (const Json& entry : (*json)[key]) list->push_back(entry);
    }
    if (!list->empty()) (*json)[key] = *list;
  }
  for (std::size_t k = 0; k < system.constraints.size(); ++k)
    (*json)["constraints"][k]["name"] = constraint_name(system, k);
  for (std::size_t k = system.forces.size() - own("forces", system.forces.size()); k < system.forces.size(); ++k) {
    std::visit(
        [&]<class Group>(const Group& group) {
          if constexpr (HasEnergy<Group>) (*json)["forces"].push_back(energy_as_json(group));
        },
        system.forces[k]);
  }
}

std::vector<double> distances(const System& system, const std::vector<std::array<Index, 2>>& pairs) {
  std::vector<double> result;
  for (const auto& pair : pairs) {
    const StartingPlaces at{system.positions, pair};
    result.push_back(norm(at[1] - at[0]));
  }
  return result;
}

/// Writes the numbers that the old positions gave, so that they stay as they were. Prescribed motions are taken at t =
/// 0, as the search does.
void write_initial_numbers(const System& system, Json* json) {
  const auto write_parameter = [&]<class Group>(const Group& group, Json* entry) {
    if constexpr (requires { KindOf<Group>::parameter; }) {
      if (!(group.*KindOf<Group>::parameter).is_initial()) return;
      std::vector<double> numbers;
      for (std::size_t k = 0; k < (group.*KindOf<Group>::members).size(); ++k)
        numbers.push_back(measure_initial(system, group, 0.0, k));
      (*entry)[std::string(detail::name_of_member<KindOf<Group>::parameter>())] = numbers;
    }
  };
  for (std::size_t k = 0; k < system.constraints.size(); ++k)
    std::visit([&](const auto& group) { write_parameter(group, &(*json)["constraints"][k]); }, system.constraints[k]);
  for (std::size_t k = 0; k < system.coordinates.size(); ++k) {
    Json& entry = (*json)["coordinates"][k];
    std::visit([&](const auto& group) { write_parameter(group, &entry); }, system.coordinates[k]);
    const auto* const chain = std::get_if<ChainAngles>(&system.coordinates[k]);
    if (chain == nullptr || !chain->length.is_initial()) continue;
    std::vector<std::array<Index, 2>> links{{chain->anchor, chain->points[0]}};
    for (std::size_t i = 1; i < chain->points.size(); ++i) links.push_back({chain->points[i - 1], chain->points[i]});
    entry["length"] = distances(system, links);
  }
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const auto* const springs = std::get_if<Springs>(&system.forces[k]);
    const auto* const bonds = std::get_if<Bonds>(&system.forces[k]);
    const auto* const pairs = std::get_if<PairForces>(&system.forces[k]);
    if (springs != nullptr && springs->rest_length.is_initial())
      (*json)["forces"][k]["rest_length"] = distances(system, springs->pairs);
    if (bonds != nullptr && bonds->law != BondLaw::Fene && bonds->rest_length.is_initial())
      (*json)["forces"][k]["rest_length"] = distances(system, bonds->pairs);
    if (pairs != nullptr && pairs->box != Vector3{}) (*json)["forces"][k]["box"] = pairs->box;
  }
}

/// Removes coordinates of formulas, whose q belongs to other positions; the constraints describe the same motion.
void leave_out_formula_coordinates(const System& system, Json* json) {
  const auto is_formula = [](const Coordinates& each) { return std::holds_alternative<UserCoordinates>(each); };
  if (std::ranges::none_of(system.coordinates, is_formula)) return;
  json->erase("coordinates");
  if (json->contains("solver")) (*json)["solver"].erase("form");
}

/// Gives the sides that the search was asked for to their constraints, so that all members keep their numbers.
void write_sides(const scene::Scene& scene, Json* json) {
  for (const OneSided& each : scene.equilibrium.one_sided)
    for (std::size_t g = 0; g < scene.system.constraints.size(); ++g)
      if (constraint_name(scene.system, g) == each.constraint) (*json)["constraints"][g]["side"] = name_of(each.side);
  if (json->contains("equilibrium")) json->at("equilibrium").erase("one_sided");
}

/// Returns true if an entry of the scene contains a function of time.
bool depends_on_time(const Json& json) {
  return json.is_structured() && (json.contains("formula") || json.contains("table") ||
                                  std::ranges::any_of(json, [](const Json& each) { return depends_on_time(each); }));
}

/// Makes the motion start at the time of the equilibrium. Moving supports and constraints give velocities, so the start
/// is then projected.
void write_start(double at, Json* json) {
  Json& motion = (*json)["motion"];
  if (at != 0.0) {
    motion["t_start"] = at;
    if (motion.contains("t_end") && motion["t_end"] <= at) motion["t_end"] = motion["t_end"].get<double>() + at;
  }
  const auto moves = [&](const char* key) { return json->contains(key) && depends_on_time((*json)[key]); };
  if (moves("supports") || moves("constraints")) motion["start"] = "project";
  if (motion.is_null()) json->erase("motion");
}

/// Returns the numbers of each point, [3n], as a list.
Json list_rows(const std::vector<double>& numbers) {
  Json rows = Json::array();
  for (std::size_t i = 0; i < numbers.size(); i += 3) rows.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  return rows;
}

/// Writes the scene's own text with the new positions, and the velocities of the frame in which they rest. Supports
/// keep the positions from which their motion is measured.
void write_scene(const fs::path& path, const scene::Scene& scene, const EquilibriumResult& found) {
  std::ifstream file(scene.file);
  Json json = Json::parse(file);
  make_paths_absolute(scene.file.parent_path(), &json);
  json["name"] = scene.name;
  if (!json.contains("points")) write_what_came_with_points(scene.system, &json);
  write_initial_numbers(scene.system, &json);
  leave_out_formula_coordinates(scene.system, &json);
  write_sides(scene, &json);
  write_start(scene.equilibrium.at, &json);
  json.erase("generate");
  if (json.erase("import") > 0) {
    // Units and cell were those of the file.
    const Json told = json_of(scene.system.units);
    Json units;
    for (const auto& [key, letters] : told.items())
      if (!letters.is_null()) units[key] = letters;
    json["units"] = scene.system.units.name == "none" ? Json("none") : units;
    if (const std::optional<Cell>& cell = scene.system.cell; cell && cell->is_periodic_everywhere()) {
      const auto e = edges_of(*cell);
      json["cell"] = {{"edges", {{e[0], e[1], e[2]}, {e[3], e[4], e[5]}, {e[6], e[7], e[8]}}},
                      {"origin", cell->origin}};
    }
  }
  std::vector<double> positions = found.positions;
  for (const Support& support : scene.system.supports) {
    for (const Index point : support.points) {
      const auto first = 3 * static_cast<std::ptrdiff_t>(point);
      std::copy_n(scene.system.positions.begin() + first, 3, positions.begin() + first);
    }
  }
  json["points"] = {{"positions", list_rows(positions)}, {"masses", scene.system.masses}};
  if (std::ranges::any_of(found.velocities, [](double each) { return each != 0.0; }))
    json["points"]["velocities"] = list_rows(found.velocities);
  replace_file(path, [&](OutputFile* out) { out->write(json.dump() + "\n"); });
}

}  // namespace

void write_equilibrium(const fs::path& directory, const scene::Scene& scene, const EquilibriumResult& found,
                       std::span<const Observed> observed, const std::optional<Modes>& modes) {
  write_summary(directory, scene, found, observed, modes);
  const ShownParts shown = choose_parts(scene.system, {});
  const std::vector<double> at_rest(found.positions.size(), 0.0);
  open_xyz({.path = directory / places_at_rest_name, .shown = &shown, .cell = scene.system.cell})
      ->write({.time = scene.equilibrium.at, .positions = found.positions, .velocities = at_rest});
  if (found.stability.status != Stability::None) write_scene(directory / scene_at_rest_name, scene, found);
}

void write_frame_at_rest(const fs::path& directory, const System& system, const tanor::Solution& rest) {
  const ShownParts shown = choose_parts(system, {});
  const std::vector<double> still(rest.positions.size());
  std::vector<double> forces;
  if (std::ranges::any_of(find_held_points(system), std::identity{}))
    forces = find_guide_forces(shown, rest.positions, find_tensions(shown, rest.multipliers), rest.reactions,
                               rest.support_forces);
  const std::vector<double> tensions = find_tensions(shown, unique_multipliers(rest.multipliers, rest.self_stress));
  VtpTrajectory(directory, &shown, false)
      .write({.time = rest.time,
              .is_at_rest = true,
              .positions = rest.positions,
              .velocities = still,
              .accelerations = still,
              .tensions = tensions,
              .guide_forces = forces,
              .guides = list_guides(system, shown, list_guides_without_picture(system, shown, rest.time), rest.time,
                                    rest.time),
              .gravity = find_gravity(system)});
}

}  // namespace tanor::report
