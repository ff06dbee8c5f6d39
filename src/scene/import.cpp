#include "scene/import.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "scene/lammps_data.hpp"

namespace tanor::scene {
namespace {

/// Rods along the bonds of the wanted types (empty: all); moves atoms so that they are short.
Rods make_rods(const LammpsData& data, const std::vector<std::int64_t>& types, std::vector<Vector3>* positions) {
  Rods rods{.name = "rods", .pairs = {}, .length = {}, .offsets = {}};
  for (const LammpsData::Bond& bond : data.bonds)
    if (types.empty() || std::find(types.begin(), types.end(), bond.type) != types.end())
      rods.pairs.push_back(bond.atoms);

  rods.offsets = join_molecules(data.cell, rods.pairs, positions);
  const auto is_zero = [](const Vector3& offset) { return offset == Vector3{}; };
  if (std::all_of(rods.offsets.begin(), rods.offsets.end(), is_zero)) rods.offsets.clear();
  return rods;
}

std::vector<double> flatten(const std::vector<Vector3>& vectors) {
  std::vector<double> numbers;
  numbers.reserve(3 * vectors.size());
  for (const Vector3& vector : vectors) numbers.insert(numbers.end(), vector.begin(), vector.end());
  return numbers;
}

}  // namespace

PointSet read_import(const Cursor& import, const Context& context) {
  import.object({"file", "format", "bonds", "types", "angles"});
  import["format"].choice<int>({{ "lammps-data", 0 }}, 0, {"obj", "ply", "gro", "pdb"});
  import["bonds"].choice<int>({{ "rods", 0 }}, 0);
  import["angles"].choice<int>({{ "free", 0 }}, 0, {"rigid"});

  const Cursor file = import["file"];
  LammpsData data = file.locate([path = context.file(file)] { return read_lammps_data(path); });
  if (data.positions.empty()) file.fail("a file with at least one atom");
  std::vector<std::int64_t> types;
  for (const Cursor type : import["types"].optional_list("a list of bond types"))
    types.push_back(type.integer(1, data.num_bond_types));

  PointSet set;
  set.source = fmt::format("import: {} (lammps-data)", file.string());
  set.constraints.emplace_back(make_rods(data, types, &data.positions));
  set.positions = flatten(data.positions);
  set.velocities = flatten(data.velocities);
  set.masses = std::move(data.masses);
  set.cell = data.cell;
  return set;
}

}  // namespace tanor::scene
