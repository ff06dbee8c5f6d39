#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/suggestion.hpp"
#include "scene/atom_styles.hpp"
#include "scene/import_energies.hpp"
#include "scene/parts.hpp"
#include "scene/points.hpp"
#include "scene/text_file.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

/// A format, and what its files' names end in. Those of lammps-data are free: others are such files if they look like
/// one.
struct Format {
  std::string_view name, endings;
  Imported (*read)(const std::string& name, std::string_view text);  ///< null for lammps-data

  bool is_lammps() const { return read == nullptr; }
};
constexpr Format formats[] = {{"lammps-data", ".data .lmp", nullptr},
                              {"obj", ".obj", read_obj},
                              {"ply", ".ply", read_ply},
                              {"gro", ".gro", read_gro},
                              {"pdb", ".pdb .ent", read_pdb}};

/// Returns the format that the scene names, or else that of the file's ending, or null if the ending is unknown.
const Format* find_format(const Cursor& format, const Cursor& file) {
  if (format) {
    std::vector<std::string_view> names;
    for (const Format& each : formats) names.push_back(each.name);
    return &formats[format.choice_index(names)];
  }
  const std::string ending = file.is_string() ? ending_of(file.string()) : "";
  for (const Format& each : formats) {
    const auto endings = split_words(each.endings);
    if (std::ranges::find(endings, ending) != endings.end()) return &each;
  }
  return nullptr;
}

/// Refuses a file of unknown ending that is not even lammps-data.
void require_lammps_data(const std::string& name, const std::string& text, const Cursor& file, const Cursor& format) {
  if (file.locate([&] { return is_lammps_data(name, text); })) return;
  format.complain(
      fmt::format("missing, and neither the ending of {} nor a line \"… atoms\" of lammps-data tells it, "
                  "wanted one of lammps-data, obj, ply, gro, pdb",
                  quote(name)));
}

/// Returns rods along the bonds of the wanted types, and moves atoms so that these are short. Bonds of length 0, as of
/// cores and shells, are no rods: they are counted in `unread`.
Rods make_rods(const std::vector<std::int64_t>& types, bool all, bool others_are_energies, Imported* data) {
  Rods rods{.name = "rods", .pairs = {}, .length = {}, .offsets = {}};
  std::size_t num_points = 0, num_other_types = 0;
  for (const Imported::Bond& bond : data->bonds) {
    if (!all && std::find(types.begin(), types.end(), bond.type) == types.end()) {
      ++num_other_types;
      continue;
    }
    const auto [i, j] = bond.atoms;
    const bool has_length =
        data->positions[static_cast<std::size_t>(i)] != data->positions[static_cast<std::size_t>(j)];
    has_length ? rods.pairs.push_back(bond.atoms) : void(++num_points);
  }
  if (num_other_types > 0 && !others_are_energies)
    data->unread.push_back(fmt::format("what joins atoms by bonds of other types (bonds: {})", num_other_types));
  if (num_points > 0) data->unread.push_back(fmt::format("what joins atoms at one place (bonds: {})", num_points));

  rods.offsets = join_molecules(data->cell, rods.pairs, &data->positions);
  const auto is_zero = [](const Vector3& offset) { return offset == Vector3{}; };
  if (std::all_of(rods.offsets.begin(), rods.offsets.end(), is_zero)) rods.offsets.clear();
  return rods;
}

/// Returns the angles of all pairs of rods that meet in a point, for files that list no angles.
std::vector<Imported::Angle> find_angles(const Rods& rods, std::size_t num_points, const Cursor& wanted) {
  std::vector<std::vector<std::int32_t>> neighbours(num_points);
  for (const auto& [i, j] : rods.pairs) {
    neighbours[static_cast<std::size_t>(i)].push_back(j);
    neighbours[static_cast<std::size_t>(j)].push_back(i);
  }
  constexpr std::size_t most_rods = 100;
  std::vector<Imported::Angle> angles;
  for (std::size_t corner = 0; corner < num_points; ++corner) {
    const std::vector<std::int32_t>& ends = neighbours[corner];
    if (ends.size() > most_rods)
      wanted.complain(fmt::format("found {} rods at point {}, wanted at most {} where all angles are rigid",
                                  ends.size(), corner, most_rods));
    for (std::size_t a = 0; a < ends.size(); ++a)
      for (std::size_t b = a + 1; b < ends.size(); ++b)
        angles.push_back({0, {ends[a], static_cast<std::int32_t>(corner), ends[b]}});
  }
  return angles;
}

/// Names an angle by its number in the file, or else by its points.
std::string name_angle(const Imported::Angle& angle) {
  if (angle.id > 0) return fmt::to_string(angle.id);
  return fmt::format("{}-{}-{}", angle.atoms[0], angle.atoms[1], angle.atoms[2]);
}

/// Returns the sine of the angle between two vectors.
double sine(const Vector3& a, const Vector3& b) {
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  return std::hypot(x, y, z) / (std::hypot(a[0], a[1], a[2]) * std::hypot(b[0], b[1], b[2]));
}

/// Returns constraints that keep all angles of the file. `positions` are those after molecules were joined.
Angles make_angles(const Imported& data, const std::vector<Vector3>& positions, const Cursor& wanted) {
  // At a smaller sine the slope of the cosine is lost in rounding.
  constexpr double least_sine = 1e-7;
  Angles angles{.name = "angles", .triples = {}, .cosine = {}};
  std::string straight, torn;
  const auto add = [](const Imported::Angle& angle, std::string* list) {
    constexpr std::size_t most_named = 200;  // characters
    if (list->size() > most_named) {
      if (!list->ends_with("…")) *list += ", …";
      return;
    }
    *list += (list->empty() ? "" : ", ") + name_angle(angle);
  };
  for (const Imported::Angle& angle : data.angles) {
    const auto [i, corner, j] = angle.atoms;
    if (!are_side_by_side(data.cell, positions, corner, i) || !are_side_by_side(data.cell, positions, corner, j))
      add(angle, &torn);
    else if (!(sine(between(positions, corner, i), between(positions, corner, j)) > least_sine))
      add(angle, &straight);
    angles.triples.push_back(angle.atoms);
  }
  if (!torn.empty())
    wanted.complain(
        fmt::format("found angles that reach through a periodic face: {}, wanted atoms side by side once the "
                    "rods have joined them",
                    torn));
  if (!straight.empty())
    wanted.complain(
        fmt::format("found straight angles: {}, wanted angles that bend, which their cosines can hold", straight));
  return angles;
}

std::vector<double> flatten(const std::vector<Vector3>& vectors) {
  std::vector<double> numbers;
  numbers.reserve(3 * vectors.size());
  for (const Vector3& vector : vectors) numbers.insert(numbers.end(), vector.begin(), vector.end());
  return numbers;
}

/// Returns one mass for all, or the masses of the file, or those of its elements, or 1.
std::vector<double> find_masses(const Imported& data, const Cursor& mass, const Cursor& file) {
  const std::size_t num_points = data.positions.size();
  if (mass) return std::vector<double>(num_points, mass.positive());
  if (!data.masses.empty()) return data.masses;
  if (data.elements.empty()) return std::vector<double>(num_points, 1.0);
  if (!data.without_element.empty())
    file.complain(fmt::format("{} is of no element that its name tells; give one mass for all by /import/mass",
                              data.without_element));
  std::vector<double> masses;
  for (const Element* element : data.elements) masses.push_back(element->mass);
  return masses;
}

// ---- units of LAMMPS ----

/// A set of units, and the ratio of its unit of time to the consistent one, in which F = m a holds for its units of
/// mass, length and energy.
struct UnitSet {
  std::string_view name;
  double time_ratio;       ///< the file's unit of time over the consistent one
  const char* consistent;  ///< the consistent unit in words; null if both are the same
};
constexpr double femtoseconds_of_real = 48.88821291, femtoseconds_of_metal = 10.18050571;
constexpr UnitSet unit_sets[] = {{"lj", 1.0, nullptr},
                                 {"si", 1.0, nullptr},
                                 {"cgs", 1.0, nullptr},
                                 {"micro", 1.0, nullptr},
                                 {"nano", 1.0, nullptr},
                                 // The consistent unit is sqrt(g/mol angstrom^2/(kcal/mol)), or the same with eV.
                                 {"real", 1.0 / femtoseconds_of_real, "48.88821291 fs"},
                                 {"metal", 1e3 / femtoseconds_of_metal, "10.18050571 fs"}};

/// Returns the units that `key` or else the file names, or null if neither does.
const UnitSet* find_units(const Cursor& key, const Imported& data) {
  if (!key && data.units.empty()) return nullptr;
  const std::string name = key ? key.string() : data.units;
  const auto* const found = std::ranges::find(unit_sets, name, &UnitSet::name);
  if (found != std::end(unit_sets)) return found;
  if (!key && name != "electron") return nullptr;  // the first line is prose
  key.complain(fmt::format("found the units {}{}, wanted one of lj, real, metal, si, cgs, micro, nano", quote(name),
                           suggest(name, {"lj", "real", "metal", "si", "cgs", "micro", "nano"})));
}

/// Converts velocities to the unit of time in which F = m a holds. Returns a remark about it.
std::string convert_velocities(const UnitSet* units, Imported* data) {
  if (units == nullptr || units->consistent == nullptr) return {};
  for (Vector3& velocity : data->velocities)
    for (double& component : velocity) component /= units->time_ratio;
  return fmt::format(", units {}: the unit of time is {}", units->name, units->consistent);
}

/// Returns the letters of a format's units: of those that a LAMMPS file or its key names, else of lj.
Units letters_of(std::string_view format, std::string_view units) {
  if (units == "cgs") return {"cgs", "cm", "g", "s", "dyn", "erg", "K", "Ba", 1.380649e-16};
  if (units == "micro")
    return {"micro", "um", "pg", "us", "pg um/us^2", "pg um^2/us^2", "K", "pg/(um us^2)", 1.380649e-8};
  if (units == "nano") return {"nano", "nm", "ag", "ns", "ag nm/ns^2", "ag nm^2/ns^2", "K", "ag/(nm ns^2)", 0.01380649};
  if (!units.empty()) return units_from_name(units);
  if (format == "lammps-data") return units_from_name("lj");
  if (format == "gro") return {"gro", "nm", "u", "ps", "kJ/mol/nm", "kJ/mol", "K", "kJ/mol/nm^3", 0.00831446261815324};
  if (format == "pdb") return {.name = "pdb", .length = "angstrom", .mass = "u"};  // times are the user's
  return {};
}

enum class BondRule { Rods, Distance, None, Energies };
enum class AngleRule { Free, Rigid, Energies };

/// Returns the atom style that the scene names, or an empty text.
std::string read_atom_style(const Cursor& style) {
  if (style && find_atom_styles(style.string()).empty())
    style.complain(fmt::format("found the atom style {}{}, wanted one of {}", quote(style.string()),
                               suggest(style.string(), names_of_atom_styles()),
                               fmt::join(names_of_atom_styles(), ", ")));
  return style.string("");
}

/// Names sections of which nothing is asked for.
void name_unused(const ImportChoices& choices, AngleRule angle_rule, Imported* data) {
  const auto name = [&](bool is_unused, bool is_there, const char* section) {
    if (is_unused && is_there) data->unread.push_back(std::string("the section ") + section);
  };
  const auto has = [](const Imported::Coefficients& each) { return !each.of_type.empty() || !each.error.empty(); };
  name(!choices.bonds_are_energies, has(data->bond_coefficients), "Bond Coeffs");
  name(angle_rule == AngleRule::Free, !data->angles.empty(), "Angles");
  name(!choices.angles_are_energies, has(data->angle_coefficients), "Angle Coeffs");
  name(!choices.dihedrals_are_energies, !data->dihedrals.empty(), "Dihedrals");
  name(!choices.dihedrals_are_energies, has(data->dihedral_coefficients), "Dihedral Coeffs");
}

/// Reads the bonds that become rods, if the scene wants others than those of the file.
void choose_bonds(const Cursor& bonds, BondRule rule, Imported* data) {
  if (rule != BondRule::None && rule != BondRule::Distance) return;
  if (!data->bonds.empty())
    data->unread.push_back(fmt::format("what joins atoms by bonds (bonds: {})", data->bonds.size()));
  data->bonds.clear();
  if (rule == BondRule::None) return;
  if (data->elements.empty()) bonds.fail("rods or none: the file knows no elements, whose radii tell bonds");
  data->bonds = bonds.locate([&] { return find_bonds_by_distance(*data); });
}

/// Moves atoms so that bonds which are energies are short.
void join_bonds(Imported* data) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const Imported::Bond& bond : data->bonds) pairs.push_back(bond.atoms);
  (void)join_molecules(data->cell, pairs, &data->positions);
}

/// Complains about keys that are not read, and about energies for which the format has no coefficients.
void check_energies(const Cursor& import, const Format& format, const ImportChoices& choices) {
  const auto keep_to = [&](bool reads_it, const char* key, const char* wanted) {
    if (!reads_it && import[key]) import[key].complain(fmt::format("found without {}, which reads it", wanted));
  };
  keep_to(choices.bonds_are_energies, "bond_style", R"("bonds": "energies")");
  keep_to(choices.bonds_are_energies, "fene_repulsion", R"("bonds": "energies")");
  keep_to(choices.angles_are_energies, "angle_style", R"("angles": "energies")");
  keep_to(choices.dihedrals_are_energies, "dihedral_style", R"("dihedrals": "energies")");
  if (format.is_lammps()) return;
  for (const char* const key : {"units", "atom_style"})
    if (import[key]) import[key].complain("found without lammps-data, which reads it");
  for (const auto& [is_wanted, key] :
       {std::pair(choices.bonds_are_energies, "bonds"), std::pair(choices.angles_are_energies, "angles"),
        std::pair(choices.dihedrals_are_energies, "dihedrals")})
    if (is_wanted) import[key].complain("found energies, whose coefficients lammps-data alone has");
}

}  // namespace

PointSet read_import(const Cursor& import, const Context& context) {
  import.object(keys_of("import"));
  const Cursor file = import["file"];
  const Format* const known_format = find_format(import["format"], file);
  const Format& format = known_format != nullptr ? *known_format : formats[0];
  const auto rule = import["bonds"].choice<BondRule>({{"rods", BondRule::Rods},
                                                      {"distance", BondRule::Distance},
                                                      {"none", BondRule::None},
                                                      {"energies", BondRule::Energies}},
                                                     BondRule::Rods);
  const auto angle_rule = import["angles"].choice<AngleRule>(
      {{"free", AngleRule::Free}, {"rigid", AngleRule::Rigid}, {"energies", AngleRule::Energies}}, AngleRule::Free);
  ImportChoices choices{
      .bonds_are_energies = rule == BondRule::Energies,
      .angles_are_energies = angle_rule == AngleRule::Energies,
      .dihedrals_are_energies = import["dihedrals"].choice<bool>({{"free", false}, {"energies", true}}, false),
      .pairs_repel = import["fene_repulsion"].choice<bool>({{"none", false}, {"pair", true}}, false),
      .rod_types = {}};
  check_energies(import, format, choices);

  const std::string atom_style = read_atom_style(import["atom_style"]);
  const std::filesystem::path path = context.file(file);
  if (import["get"] && !std::filesystem::exists(path))
    file.complain(fmt::format("{} is not there; {} gets it", path.string(), import["get"].string()));
  const std::string file_name = path.filename().string(), text = file.locate([&] { return read_text(path); });
  if (known_format == nullptr) require_lammps_data(file_name, text, file, import["format"]);
  Imported data = file.locate([&] {
    return format.is_lammps() ? read_lammps_data(file_name, text, atom_style) : format.read(file_name, text);
  });
  if (data.positions.empty())
    file.fail(fmt::format("a file of format {} with at least one atom or vertex", format.name));
  for (const Cursor type : import["types"].optional_list("a list of bond types"))
    choices.rod_types.push_back(type.integer(1, data.num_bond_types));
  choose_bonds(import["bonds"], rule, &data);

  const UnitSet* const units = find_units(import["units"], data);
  PointSet set;
  set.source = fmt::format("import: {} ({}{}{})", file.string(), format.name,
                           rule == BondRule::Distance ? ", bonds by distance" : "", convert_velocities(units, &data));
  set.masses = find_masses(data, import["mass"], file);
  if (choices.bonds_are_energies) join_bonds(&data);
  const bool all_are_rods = !choices.bonds_are_energies && choices.rod_types.empty();
  Rods rods = make_rods(choices.rod_types, all_are_rods, choices.bonds_are_energies, &data);
  name_unused(choices, angle_rule, &data);
  for (const std::string& what : data.unread)
    set.left_out.push_back(fmt::format("import: {} of {} is not read", what, file.string()));
  if (angle_rule == AngleRule::Rigid && !format.is_lammps())
    data.angles = find_angles(rods, data.positions.size(), import["angles"]);
  if (!choices.bonds_are_energies || !rods.pairs.empty()) set.constraints.emplace_back(std::move(rods));
  set.forces = make_energies(data, choices, import);
  if (angle_rule == AngleRule::Rigid) set.constraints.emplace_back(make_angles(data, data.positions, import["angles"]));
  set.positions = flatten(data.positions);
  set.velocities = flatten(data.velocities);
  set.cell = data.cell;
  set.units = letters_of(format.name, units == nullptr ? "" : units->name);
  if (units == nullptr && !data.units.empty())
    set.left_out.push_back(
        fmt::format("import: the first line of {} says units {}, which LAMMPS has not; nothing is converted, as of lj",
                    file.string(), quote(data.units)));
  return set;
}

}  // namespace tanor::scene
