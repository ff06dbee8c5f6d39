#include "scene/constraints.hpp"

#include <fmt/format.h>

#include "scene/kind.hpp"

namespace tanor::scene {
namespace {

Constraint read_rods(const Cursor& entry, const Context& context) {
  Rods rods;
  rods.name = entry["name"].string("");
  rods.pairs = context.tuples<2>(entry["pairs"]);
  rods.length = context.parameter(entry["length"], rods.pairs.size());
  if (const Cursor offsets = entry["offsets"]) {
    rods.offsets = context.vectors(offsets);
    if (rods.offsets.size() != rods.pairs.size())
      offsets.fail(fmt::format("{} vectors, one a pair", rods.pairs.size()));
  }
  return rods;
}

Constraint read_planes(const Cursor& entry, const Context& context) {
  Planes planes;
  planes.name = entry["name"].string("");
  planes.points = context.points(entry["points"]);
  planes.normal = context.vector_function(entry["normal"]);
  planes.offset = context.parameter(entry["offset"], planes.points.size(), 0.0);
  return planes;
}

Constraint read_spheres(const Cursor& entry, const Context& context) {
  Spheres spheres;
  spheres.name = entry["name"].string("");
  spheres.points = context.points(entry["points"]);
  spheres.center = context.vector_function(entry["center"]);
  spheres.radius = context.parameter(entry["radius"], spheres.points.size());
  return spheres;
}

Constraint read_lines(const Cursor& entry, const Context& context) {
  Lines lines;
  lines.name = entry["name"].string("");
  lines.points = context.points(entry["points"]);
  lines.origin = context.vector_function(entry["origin"]);
  lines.direction = context.vector_function(entry["direction"]);
  return lines;
}

Constraint read_circles(const Cursor& entry, const Context& context) {
  Circles circles;
  circles.name = entry["name"].string("");
  circles.points = context.points(entry["points"]);
  circles.center = context.vector_function(entry["center"]);
  circles.normal = context.vector_function(entry["normal"]);
  circles.radius = context.parameter(entry["radius"], circles.points.size());
  return circles;
}

Constraint read_angles(const Cursor& entry, const Context& context) {
  Angles angles;
  angles.name = entry["name"].string("");
  angles.triples = context.tuples<3>(entry["triples"]);
  angles.cosine = context.parameter(entry["cosine"], angles.triples.size());
  return angles;
}

Constraint read_pulleys(const Cursor& entry, const Context& context) {
  Pulleys pulleys;
  pulleys.name = entry["name"].string("");
  pulleys.pairs = context.tuples<2>(entry["pairs"]);
  pulleys.a = entry["a"].vector3();
  pulleys.b = entry["b"].vector3();
  pulleys.length = context.parameter(entry["length"], pulleys.pairs.size());
  pulleys.ratio = entry["ratio"].number(1.0);
  return pulleys;
}

Constraint read_linears(const Cursor& entry, const Context& context) {
  Linears linears;
  linears.name = entry["name"].string("");
  linears.coefficients = context.vectors(entry["coefficients"]);
  const std::string wanted = fmt::format("{} points, one a coefficient", linears.coefficients.size());
  for (const Cursor tuple : entry["tuples"].list("a list of lists of points")) {
    if (tuple.list(wanted).size() != linears.coefficients.size()) tuple.fail(wanted);
    std::vector<Index>& points = linears.tuples.emplace_back();
    for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
  }
  linears.value = context.parameter(entry["value"], linears.tuples.size(), 0.0);
  return linears;
}

Constraint read_formula(const Cursor& entry, const Context& context) {
  UserConstraints user;
  user.name = entry["name"].string("");
  std::size_t num_points = 1;
  std::string wanted = "a list of points, of one size in all tuples";
  for (const Cursor tuple : entry["points"].list("a list of lists of points")) {
    std::vector<Index>& points = user.tuples.emplace_back();
    for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
    if (user.tuples.size() == 1) {
      num_points = points.size();
      wanted = fmt::format("{} points, as in the first tuple", num_points);
    }
    if (points.size() != num_points || points.empty()) tuple.fail(points.empty() ? "at least one point" : wanted);
  }
  const Cursor equation = entry["equation"];
  const std::string& text = equation.string();
  user.kernel =
      equation.locate([&] { return formula_constraint(text, static_cast<int>(num_points), context.parameters); });
  return user;
}

const std::vector<Kind<Constraint>> kinds = {
    {"rod", {"name", "pairs", "length", "offsets"}, read_rods},
    {"plane", {"name", "points", "normal", "offset"}, read_planes},
    {"sphere", {"name", "points", "center", "radius"}, read_spheres},
    {"line", {"name", "points", "origin", "direction"}, read_lines},
    {"circle", {"name", "points", "center", "normal", "radius"}, read_circles},
    {"angle", {"name", "triples", "cosine"}, read_angles},
    {"pulley", {"name", "pairs", "a", "b", "length", "ratio"}, read_pulleys},
    {"linear", {"name", "tuples", "coefficients", "value"}, read_linears},
    {"formula", {"name", "points", "equation"}, read_formula},
};

}  // namespace

std::vector<Constraint> read_constraints(const Cursor& list, const Context& context) {
  std::vector<Constraint> constraints;
  for (const Cursor entry : list.optional_list("a list of constraints"))
    constraints.push_back(read_kind(entry, kinds, {}, context));
  return constraints;
}

std::vector<Support> read_supports(const Cursor& list, const Context& context) {
  std::vector<Support> supports;
  for (const Cursor entry : list.optional_list("a list of supports")) {
    entry.object({"name", "points", "motion"});
    const Cursor motion = entry["motion"];
    if (motion && !motion.says("fixed") && !motion.is_object())
      motion.fail(R"("fixed", {"formula": ["…", "…", "…"]} or {"table": "…"})");
    supports.push_back({.name = entry["name"].string(""),
                        .points = context.points(entry["points"]),
                        .displacement = motion.is_object() ? context.vector_function(motion) : VectorFunction()});
  }
  return supports;
}

}  // namespace tanor::scene
