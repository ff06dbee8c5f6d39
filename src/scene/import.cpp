#include "scene/import.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "scene/import_energies.hpp"
#include "scene/lammps_data.hpp"

namespace tanor::scene {
namespace {

/// Moves atoms so that bonds which are energies are short.
void join_bonds(LammpsData* data) {
  std::vector<std::array<std::int32_t, 2>> pairs;
  for (const LammpsData::Bond& bond : data->bonds) pairs.push_back(bond.atoms);
  (void)join_molecules(data->cell, pairs, &data->positions);
}

/// Rods along the bonds of the wanted types; moves atoms so that they are short.
Rods make_rods(const LammpsData& data, const std::vector<std::int64_t>& types, bool all,
               std::vector<Vector3>* positions) {
  Rods rods{.name = "rods", .pairs = {}, .length = {}, .offsets = {}};
  for (const LammpsData::Bond& bond : data.bonds)
    if (all || std::find(types.begin(), types.end(), bond.type) != types.end()) rods.pairs.push_back(bond.atoms);

  rods.offsets = join_molecules(data.cell, rods.pairs, positions);
  const auto is_zero = [](const Vector3& offset) { return offset == Vector3{}; };
  if (std::all_of(rods.offsets.begin(), rods.offsets.end(), is_zero)) rods.offsets.clear();
  return rods;
}

/// Sine of the angle between two vectors.
double sine(const Vector3& a, const Vector3& b) {
  const double x = a[1] * b[2] - a[2] * b[1], y = a[2] * b[0] - a[0] * b[2], z = a[0] * b[1] - a[1] * b[0];
  return std::hypot(x, y, z) / (std::hypot(a[0], a[1], a[2]) * std::hypot(b[0], b[1], b[2]));
}

/// All angles of the file, held as they are. `positions`: of molecules that are joined.
Angles make_angles(const LammpsData& data, const std::vector<Vector3>& positions, const Cursor& wanted) {
  // Below, the cosine has no slope to rounding.
  constexpr double least_sine = 1e-7;
  Angles angles{.name = "angles", .triples = {}, .cosine = {}};
  std::string straight, torn;
  const auto add = [](std::int64_t id, std::string* list) {
    *list += list->empty() ? fmt::to_string(id) : fmt::format(", {}", id);
  };
  for (const LammpsData::Angle& angle : data.angles) {
    const auto arm = [&](std::int32_t end) {
      const Vector3 &from = positions[static_cast<std::size_t>(angle.atoms[1])],
                    &to = positions[static_cast<std::size_t>(end)];
      return Vector3{to[0] - from[0], to[1] - from[1], to[2] - from[2]};
    };
    const Vector3 a = arm(angle.atoms[0]), b = arm(angle.atoms[2]);
    const std::array<std::int64_t, 3> here{};
    if (data.cell.nearest_images(a) != here || data.cell.nearest_images(b) != here)
      add(angle.id, &torn);
    else if (!(sine(a, b) > least_sine))
      add(angle.id, &straight);
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

}  // namespace

PointSet read_import(const Cursor& import, const Context& context) {
  import.object({"file", "format", "bonds", "types", "angles", "dihedrals", "bond_style", "angle_style",
                 "dihedral_style", "fene_repulsion"});
  import["format"].choice<int>({{ "lammps-data", 0 }}, 0, {"obj", "ply", "gro", "pdb"});
  const bool has_bond_energies = import["bonds"].choice<bool>({{"rods", false}, {"energies", true}}, false);
  enum class Angled { Free, Rigid, Energies };
  const Angled angled = import["angles"].choice<Angled>(
      {{"free", Angled::Free}, {"rigid", Angled::Rigid}, {"energies", Angled::Energies}}, Angled::Free);
  const bool has_dihedrals = import["dihedrals"].choice<bool>({{"free", false}, {"energies", true}}, false);
  const bool pairs_repel = import["fene_repulsion"].choice<bool>({{"none", false}, {"pair", true}}, false);
  const auto keep_to = [&](bool reads_it, const char* key, const char* wanted) {
    if (!reads_it && import[key]) import[key].complain(fmt::format("found without {}, which reads it", wanted));
  };
  keep_to(has_bond_energies, "bond_style", R"("bonds": "energies")");
  keep_to(has_bond_energies, "fene_repulsion", R"("bonds": "energies")");
  keep_to(angled == Angled::Energies, "angle_style", R"("angles": "energies")");
  keep_to(has_dihedrals, "dihedral_style", R"("dihedrals": "energies")");

  const Cursor file = import["file"];
  LammpsData data = file.locate([path = context.file(file)] { return read_lammps_data(path); });
  if (data.positions.empty()) file.fail("a file with at least one atom");
  std::vector<std::int64_t> types;
  for (const Cursor type : import["types"].optional_list("a list of bond types"))
    types.push_back(type.integer(1, data.num_bond_types));

  PointSet set;
  set.source = fmt::format("import: {} (lammps-data)", file.string());
  if (has_bond_energies) join_bonds(&data);
  Rods rods = make_rods(data, types, !has_bond_energies && types.empty(), &data.positions);
  if (!has_bond_energies || !rods.pairs.empty()) set.constraints.emplace_back(std::move(rods));
  if (angled == Angled::Rigid) set.constraints.emplace_back(make_angles(data, data.positions, import["angles"]));
  set.forces =
      make_energies(data, {has_bond_energies, angled == Angled::Energies, has_dihedrals, pairs_repel, types}, import);
  set.positions = flatten(data.positions);
  set.velocities = flatten(data.velocities);
  set.masses = std::move(data.masses);
  set.cell = data.cell;
  return set;
}

}  // namespace tanor::scene
