#include "scene/forces.hpp"

#include <fmt/format.h>

#include "scene/kind.hpp"

namespace tanor::scene {
namespace {

Force read_gravity(const Cursor& entry, const Context&) {
  Gravity gravity;
  gravity.name = entry["name"].string("");
  gravity.acceleration = entry["acceleration"].vector3();
  return gravity;
}

Force read_constant_force(const Cursor& entry, const Context& context) {
  ConstantForce constant;
  constant.name = entry["name"].string("");
  constant.points = context.points(entry["points"]);
  constant.force = context.vector_function(entry["force"]);
  return constant;
}

Force read_springs(const Cursor& entry, const Context& context) {
  Springs springs;
  springs.name = entry["name"].string("");
  springs.pairs = context.tuples<2>(entry["pairs"]);
  springs.stiffness = entry["stiffness"].non_negative();
  springs.damping = entry["damping"].non_negative(0.0);
  springs.rest_length = context.constant_parameter(entry["rest_length"], springs.pairs.size());
  return springs;
}

Force read_drag(const Cursor& entry, const Context& context) {
  Drag drag;
  drag.name = entry["name"].string("");
  drag.points = context.points(entry["points"]);
  drag.linear = entry["linear"].non_negative(0.0);
  drag.quadratic = entry["quadratic"].non_negative(0.0);
  return drag;
}

Force read_formula(const Cursor& entry, const Context& context) {
  FormulaForce force;
  force.name = entry["name"].string("");
  force.points = context.points(entry["points"]);
  const std::array<std::string, 3> components = {entry["x"].string("0"), entry["y"].string("0"),
                                                 entry["z"].string("0")};
  try {
    force.kernel = formula_force(components, context.parameters);
  } catch (const InputError& error) {
    entry[error.where().substr(1)].complain(error.what());  // "/x": the component
  }
  return force;
}

/// [lx, ly, lz], or "import": that of the file which the points come from.
Vector3 read_box(const Cursor& box, const Context& context) {
  if (!box.is_string()) return box.vector3(Vector3{});
  if (!box.says("import")) box.fail(R"(3 numbers [lx, ly, lz] or "import")");
  if (!context.cell) box.fail("[lx, ly, lz], for no file with a box is imported");
  const Cell& cell = *context.cell;
  if (cell.xy != 0.0 || cell.xz != 0.0 || cell.yz != 0.0) {
    box.fail(
        fmt::format("[lx, ly, lz], for the file's box is tilted (xy {}, xz {}, yz {})", cell.xy, cell.xz, cell.yz));
  }
  return {cell.xx, cell.yy, cell.zz};
}

Force read_pair_forces(const Cursor& entry, const Context& context) {
  PairForces pairs;
  pairs.name = entry["name"].string("");
  pairs.law = entry["law"].choice<PairLaw>();
  // Numbers of another law would be silently without effect.
  const auto keep_to = [&](bool law_has_it, const char* key, const char* laws) {
    if (!law_has_it && entry[key])
      entry[key].complain(fmt::format("found beside the law \"{}\", wanted with {} only", entry["law"].string(), laws));
  };
  const bool is_log = pairs.law == PairLaw::Log;
  keep_to(!is_log, "epsilon", "wca or lj");
  keep_to(!is_log, "sigma", "wca or lj");
  keep_to(!is_log, "box", "wca or lj");
  keep_to(pairs.law == PairLaw::Lj, "cutoff", "lj");
  keep_to(is_log, "strength", "log");
  if (const Cursor points = entry["points"]) {
    pairs.points = context.points(points);
    if (pairs.points.empty()) points.fail("at least one point");
  }
  pairs.epsilon = entry["epsilon"].positive(pairs.epsilon);
  pairs.sigma = entry["sigma"].positive(pairs.sigma);
  if (const Cursor cutoff = entry["cutoff"]) pairs.cutoff = cutoff.positive();
  pairs.strength = entry["strength"].number(pairs.strength);
  pairs.box = read_box(entry["box"], context);
  if (entry["exclude"]) pairs.exclude_rods = entry["exclude"].choice<bool>({{"rods", true}});
  return pairs;
}

const std::vector<Kind<Force>> kinds = {
    {"gravity", {"name", "acceleration"}, read_gravity},
    {"constant", {"name", "points", "force"}, read_constant_force},
    {"spring", {"name", "pairs", "stiffness", "damping", "rest_length"}, read_springs},
    {"drag", {"name", "points", "linear", "quadratic"}, read_drag},
    {"formula", {"name", "points", "x", "y", "z"}, read_formula},
    {"pair", {"name", "points", "law", "epsilon", "sigma", "cutoff", "strength", "box", "exclude"}, read_pair_forces},
};

}  // namespace

std::vector<Force> read_forces(const Cursor& list, const Context& context) {
  std::vector<Force> forces;
  for (const Cursor entry : list.optional_list("a list of forces"))
    forces.push_back(read_kind(entry, kinds, {}, context));
  return forces;
}

}  // namespace tanor::scene
