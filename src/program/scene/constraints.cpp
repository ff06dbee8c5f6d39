#include "scene/kind.hpp"

namespace tanor::scene {

/// Reads what a constraint to one side has beside the fields that its kind reads alone.
template <class Group>
void read_side(const Cursor& entry, const Context& context, Group* group) {
  std::apply([&](const auto&... field) { (read_field(entry[field.name], context, field, group), ...); },
             one_sided_fields<Group>);
}

template <>
struct Extra<Linears> {
  static constexpr bool read_alone = true;
  /// Reads the tuples, which have a point for each coefficient.
  static void read(const Cursor& entry, const Context& context, Linears* linears) {
    linears->coefficients = context.vectors(entry["coefficients"]);
    const std::string wanted = fmt::format("{} points, one a coefficient", linears->coefficients.size());
    for (const Cursor tuple : entry["tuples"].list("a list of lists of points")) {
      if (tuple.list(wanted).size() != linears->coefficients.size()) tuple.fail(wanted);
      std::vector<Index>& points = linears->tuples.emplace_back();
      for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
    }
    linears->value = context.parameter(entry["value"], linears->tuples.size(), 0.0);
    read_side(entry, context, linears);
  }
};

template <>
struct Extra<UserConstraints> {
  static constexpr std::array<std::string_view, 5> keys{"name", "points", "equation", "side", "restitution"};
  static constexpr bool read_alone = true;
  static void read(const Cursor& entry, const Context& context, UserConstraints* user) {
    std::size_t num_points = 1;
    std::string wanted = "a list of points, of one size in all tuples";
    for (const Cursor tuple : entry["points"].list("a list of lists of points")) {
      std::vector<Index>& points = user->tuples.emplace_back();
      for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
      if (user->tuples.size() == 1) {
        num_points = points.size();
        wanted = fmt::format("{} points, as in the first tuple", num_points);
      }
      if (points.size() != num_points || points.empty()) tuple.fail(points.empty() ? "at least one point" : wanted);
    }
    const Cursor equation = entry["equation"];
    const std::string& text = equation.string();
    user->kernel =
        equation.locate([&] { return formula_constraint(text, static_cast<int>(num_points), context.parameters); });
    read_side(entry, context, user);
  }
};

template std::vector<Constraint> read_entries(const Cursor&, std::string_view, const Context&);

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
