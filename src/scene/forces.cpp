#include "scene/forces.hpp"

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

const std::vector<Kind<Force>> kinds = {
    {"gravity", {"name", "acceleration"}, read_gravity},
    {"constant", {"name", "points", "force"}, read_constant_force},
    {"spring", {"name", "pairs", "stiffness", "damping", "rest_length"}, read_springs},
    {"drag", {"name", "points", "linear", "quadratic"}, read_drag},
    {"formula", {"name", "points", "x", "y", "z"}, read_formula},
};

}  // namespace

std::vector<Force> read_forces(const Cursor& list, const Context& context) {
  std::vector<Force> forces;
  for (const Cursor entry : list.optional_list("a list of forces"))
    forces.push_back(read_kind(entry, kinds, {"pair"}, context));
  return forces;
}

}  // namespace tanor::scene
