#include <algorithm>

#include <fmt/format.h>

#include "base/text.hpp"
#include "scene/kind.hpp"

namespace tanor::scene {
using namespace detail;
namespace {

/// Reads [lx, ly, lz], or "import" for the box of the file that the points come from.
Vector3 read_box(const Cursor& box, const Context& context) {
  if (!box.is_string()) return box.vector3(Vector3{});
  if (!box.says("import")) box.fail(R"(3 numbers [lx, ly, lz] or "import")");
  if (!context.cell) box.fail("[lx, ly, lz], for no file with a box is imported");
  const Cell& cell = *context.cell;
  if (cell.xy != 0.0 || cell.xz != 0.0 || cell.yz != 0.0) {
    box.fail(fmt::format("[lx, ly, lz], for the file's box is tilted (xy {}, xz {}, yz {})", detail::text(cell.xy),
                         detail::text(cell.xz), detail::text(cell.yz)));
  }
  return {cell.xx, cell.yy, cell.zz};
}

}  // namespace

/// Reads a list of at least one list of points, all of one size from 1 to `most`.
std::vector<std::vector<Index>> read_tuples(const Cursor& list, const Context& context, std::size_t most) {
  std::vector<std::vector<Index>> tuples;
  std::string wanted = fmt::format("a list of 1 to {} points", most);
  for (const Cursor tuple : list.list("a list of lists of points")) {
    std::vector<Index> points;
    for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
    if (tuples.empty() && !points.empty() && points.size() <= most)
      wanted = fmt::format("{} points, as in the first tuple", points.size());
    else if (tuples.empty() || points.size() != tuples[0].size())
      tuple.fail(wanted);
    tuples.push_back(std::move(points));
  }
  if (tuples.empty()) list.fail("one list of points or more");
  return tuples;
}

/// Components x1, y1, z1, x2, … of forces on tuples.
constexpr std::array<std::string_view, 3 * ForceKernel::most_points> tuple_components{
    "x1", "y1", "z1", "x2", "y2", "z2", "x3", "y3", "z3", "x4", "y4", "z4",
    "x5", "y5", "z5", "x6", "y6", "z6", "x7", "y7", "z7", "x8", "y8", "z8"};

template <>
struct Extra<FormulaForce> {
  static constexpr auto keys = [] {
    std::array<std::string_view, 6 + tuple_components.size()> all{"name", "points", "x", "y", "z", "tuples"};
    std::copy(tuple_components.begin(), tuple_components.end(), all.begin() + 6);
    return all;
  }();
  static constexpr bool read_alone = true;
  static void read(const Cursor& entry, const Context& context, FormulaForce* force) {
    const bool has_tuples = static_cast<bool>(entry["tuples"]);
    std::vector<std::string_view> components{"x", "y", "z"};
    if (has_tuples) {
      force->tuples = read_tuples(entry["tuples"], context, ForceKernel::most_points);
      if (entry["points"]) entry["points"].complain("found beside \"tuples\"; one of both is right");
      const std::size_t p = force->tuples[0].size();
      components.assign(tuple_components.begin(), tuple_components.begin() + static_cast<long>(3 * p));
    } else {
      force->points = context.points(entry["points"]);
    }
    refuse_other_components(entry, components, has_tuples);
    if (std::ranges::none_of(components, [&](std::string_view key) { return static_cast<bool>(entry[key]); }))
      entry.complain(fmt::format("found no component of the force, wanted one of {} to {} or more", components[0],
                                 components.back()));
    std::vector<std::string> texts;
    for (const std::string_view component : components) texts.push_back(entry[component].string("0"));
    try {
      force->kernel = has_tuples ? formula_tuple_force(texts, context.parameters)
                                 : formula_force({texts[0], texts[1], texts[2]}, context.parameters);
    } catch (const InputError& error) {
      entry[error.where().substr(1)].complain(error.what());  // "/x" names the component
    }
  }

 private:
  /// Refuses components that the force does not have, which would have no effect.
  static void refuse_other_components(const Cursor& entry, const std::vector<std::string_view>& own, bool has_tuples) {
    const auto refuse = [&](std::string_view key) {
      if (entry[key] && std::ranges::find(own, key) == own.end())
        entry[key].complain(has_tuples
                                ? fmt::format("found in a force on tuples of {} points, wanted {} to {}",
                                              own.size() / 3, own.front(), own.back())
                                : std::string("found beside \"points\", wanted x, y or z; with \"tuples\" x1, y1, …"));
    };
    for (const std::string_view key : {"x", "y", "z"}) refuse(key);
    for (const std::string_view key : tuple_components) refuse(key);
  }
};

template <>
struct Extra<PairForces> {
  static constexpr std::array<std::string_view, 14> keys{"name",   "points",   "law",   "epsilon",    "sigma",
                                                         "cutoff", "strength", "box",   "exclude",    "charges",
                                                         "length", "depth",    "width", "rest_length"};
  static constexpr bool members_are_optional = true;
  static void read(const Cursor& entry, const Context& context, PairForces* pairs) {
    pairs->law = entry["law"].choice<PairLaw>();
    const std::string law(name_of(pairs->law));
    if (law == "coulomb" && entry["box"])
      entry["box"].complain("found beside the law \"coulomb\", wanted without a box: there is no periodic sum");
    const auto has_law = [&](std::string_view laws) { return laws.find(law) != std::string_view::npos; };
    for (const Rule& rule : rules) {
      if (!has_law(rule.laws) && entry[rule.key])
        entry[rule.key].complain(fmt::format("found beside the law \"{}\", wanted with {} only", law, rule.laws));
    }
    for (const Rule& rule : rules) {
      if (has_law(rule.required_by) && !entry[rule.key])
        entry[rule.key].fail(rule.key == "charges" ? "a number, or one a point" : "a number");
    }
    if (entry["points"] && pairs->points.empty()) entry["points"].fail("at least one point");
    pairs->box = read_box(entry["box"], context);
    if (entry["exclude"]) pairs->exclude_rods = entry["exclude"].choice<bool>({{"rods", true}});
    if (const Cursor charges = entry["charges"])
      pairs->charges = context.numbers(charges, pairs->points.empty() ? context.num_points : pairs->points.size());
  }

 private:
  /// The laws that read a key; with others it would have no effect. The newer laws have no defaults.
  struct Rule {
    std::string_view key, laws, required_by;
  };
  static constexpr Rule rules[] = {{"epsilon", "wca or lj", ""},
                                   {"sigma", "wca or lj", ""},
                                   {"box", "wca, lj, yukawa or morse", ""},
                                   {"cutoff", "lj, yukawa or morse", ""},
                                   {"strength", "log, coulomb or yukawa", "coulomb yukawa"},
                                   {"charges", "coulomb", "coulomb"},
                                   {"length", "yukawa", "yukawa"},
                                   {"depth", "morse", "morse"},
                                   {"width", "morse", "morse"},
                                   {"rest_length", "morse", "morse"}};
};

template <>
struct Extra<Potential> {
  static constexpr std::array<std::string_view, 4> keys{"name", "points", "energy", "constants"};
  static constexpr bool read_alone = true;
  static void read(const Cursor& entry, const Context& context, Potential* potential) {
    read_tuples(entry["points"], context, potential);
    std::vector<std::string> names;
    if (entry["constants"]) {
      for (const auto& [name, value] : entry["constants"].members("an object of numbers by name")) {
        names.emplace_back(name);
        potential->constants.push_back(context.numbers(value, potential->points.size()));
      }
    }
    const int num_points = static_cast<int>(potential->points[0].size());
    const Cursor energy = entry["energy"];
    const std::string& text = energy.string();
    try {
      potential->kernel = formula_potential(text, num_points, context.parameters, names);
    } catch (const InputError& error) {  // "/constants/x1" names the constant; else it is the text
      const std::string_view where = error.where(), constants = "/constants/";
      const bool is_of_constant = where.starts_with(constants);
      (is_of_constant ? entry["constants"].follow(where.substr(constants.size())) : energy).complain(error.what());
    }
  }

 private:
  /// Reads lists of points of one size. Single points may also be "all" or a range.
  static void read_tuples(const Cursor& list, const Context& context, Potential* potential) {
    if (list.is_list()) {
      potential->points = scene::read_tuples(list, context, PotentialKernel::most_points);
    } else {
      for (const Index point : context.points(list)) potential->points.push_back({point});
      if (potential->points.empty()) list.complain("found no point, wanted one or more");
    }
  }
};

template <>
struct Extra<Torsions> {
  static constexpr std::array<std::string_view, 9> keys{"name",      "quadruples",   "along", "law", "coefficients",
                                                        "stiffness", "multiplicity", "phase", "rest"};
  static void check_law(const Cursor& entry, TorsionLaw law) {
    if (law != TorsionLaw::Opls && law != TorsionLaw::Multi) refuse_key_of_other_laws(entry, "coefficients");
    if (law != TorsionLaw::Periodic) refuse_key_of_other_laws(entry, "multiplicity");
  }
  static void read(const Cursor& entry, const Context&, Torsions* torsions) {
    for (const Cursor number : entry["coefficients"].optional_list("a list of numbers"))
      torsions->coefficients.push_back(number.number());
    torsions->multiplicity = static_cast<int>(entry["multiplicity"].integer(0, 1000, 1));
  }
};

template std::vector<Force> read_entries(const Cursor&, std::string_view, const Context&);

}  // namespace tanor::scene
