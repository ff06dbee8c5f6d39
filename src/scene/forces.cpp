#include <algorithm>

#include <fmt/format.h>

#include "scene/along.hpp"
#include "scene/kind.hpp"

namespace tanor::scene {
namespace {

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

}  // namespace

template <>
struct Extra<FormulaForce> {
  static constexpr std::array<std::string_view, 5> keys{"name", "points", "x", "y", "z"};
  static void read(const Cursor& entry, const Context& context, FormulaForce* force) {
    const std::array<std::string, 3> components = {entry["x"].string("0"), entry["y"].string("0"),
                                                   entry["z"].string("0")};
    try {
      force->kernel = formula_force(components, context.parameters);
    } catch (const InputError& error) {
      entry[error.where().substr(1)].complain(error.what());  // "/x": the component
    }
  }
};

template <>
struct Extra<PairForces> {
  static constexpr std::array<std::string_view, 9> keys{"name",   "points",   "law", "epsilon", "sigma",
                                                        "cutoff", "strength", "box", "exclude"};
  static constexpr bool members_are_optional = true;
  static void read(const Cursor& entry, const Context& context, PairForces* pairs) {
    pairs->law = entry["law"].choice<PairLaw>();
    // Numbers of another law would be silently without effect.
    const auto keep_to = [&](bool law_has_it, const char* key, const char* laws) {
      if (!law_has_it && entry[key])
        entry[key].complain(
            fmt::format("found beside the law \"{}\", wanted with {} only", entry["law"].string(), laws));
    };
    const bool is_log = pairs->law == PairLaw::Log;
    keep_to(!is_log, "epsilon", "wca or lj");
    keep_to(!is_log, "sigma", "wca or lj");
    keep_to(!is_log, "box", "wca or lj");
    keep_to(pairs->law == PairLaw::Lj, "cutoff", "lj");
    keep_to(is_log, "strength", "log");
    if (entry["points"] && pairs->points.empty()) entry["points"].fail("at least one point");
    pairs->box = read_box(entry["box"], context);
    if (entry["exclude"]) pairs->exclude_rods = entry["exclude"].choice<bool>({{"rods", true}});
  }
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
        potential->constants.push_back(context.constant_parameter(value, potential->points.size()).constants);
        if (potential->constants.back().empty()) value.fail("a number or a list of numbers");
      }
    }
    const int num_points = potential->points.empty() ? 1 : static_cast<int>(potential->points[0].size());
    const Cursor energy = entry["energy"];
    potential->kernel =
        energy.locate([&] { return formula_potential(energy.string(), num_points, context.parameters, names); });
  }

 private:
  /// Lists of points of one size; of single points "all" or a range, too.
  static void read_tuples(const Cursor& list, const Context& context, Potential* potential) {
    if (!list.is_list()) {
      for (const Index point : context.points(list)) potential->points.push_back({point});
      return;
    }
    std::string wanted = fmt::format("a list of 1 to {} points", PotentialKernel::most_points);
    for (const Cursor tuple : list.list("a list of lists of points")) {
      std::vector<Index> points;
      for (const Cursor member : tuple.list(wanted)) points.push_back(context.point(member));
      if (potential->points.empty() && !points.empty() && points.size() <= PotentialKernel::most_points)
        wanted = fmt::format("{} points, as in the first tuple", points.size());
      else if (potential->points.empty() || points.size() != potential->points[0].size())
        tuple.fail(wanted);
      potential->points.push_back(std::move(points));
    }
  }
};

/// Numbers that the law does not read would be silently without effect.
template <HasEnergy Group>
void refuse_numbers_of_other_laws(const Cursor& entry, const Group& group) {
  for_each_field<Group>([&](const auto& field) {
    const auto numbers = KindOf<Group>::law_numbers(group);
    const bool is_read = std::ranges::any_of(
        numbers, [&](const LawNumber& number) { return std::string_view(number.name) == field.name; });
    if (!is_read && entry[field.name])
      entry[field.name].complain(
          fmt::format("found beside the law \"{}\", which does not read it", entry["law"].string()));
  });
}

/// Members one by one, or "along": those of rods in sequence.
template <class Group>
void read_members_or_along(const Cursor& entry, const Context& context, Group* group) {
  const Cursor list = entry[list_name<Group>()], along = entry["along"];
  auto* const members = &(group->*KindOf<Group>::members);
  if (along && list) along.complain(fmt::format(R"(found beside "{}"; one of both is right)", list_name<Group>()));
  along ? read_along(along, context, members) : scene::read_members(list, context, members);
}

template <>
struct Extra<Bonds> {
  static constexpr std::array<std::string_view, 8> keys{"name",        "pairs", "law",   "stiffness",
                                                        "rest_length", "limit", "depth", "width"};
  static void read_law(const Cursor& entry, Bonds* bonds) {
    bonds->law = entry["law"].choice<BondLaw>();
    refuse_numbers_of_other_laws(entry, *bonds);
  }
};
template <>
struct Extra<Bendings> {
  static constexpr std::array<std::string_view, 6> keys{"name", "triples", "along", "law", "stiffness", "rest"};
  static void read_members(const Cursor& entry, const Context& context, Bendings* bendings) {
    read_members_or_along(entry, context, bendings);
  }
  static void read_law(const Cursor& entry, Bendings* bendings) {
    bendings->law = entry["law"].choice<BendingLaw>();
    refuse_numbers_of_other_laws(entry, *bendings);
  }
};
template <>
struct Extra<Torsions> {
  static constexpr std::array<std::string_view, 9> keys{"name",      "quadruples",   "along", "law", "coefficients",
                                                        "stiffness", "multiplicity", "phase", "rest"};
  static void read_members(const Cursor& entry, const Context& context, Torsions* torsions) {
    read_members_or_along(entry, context, torsions);
  }
  static void read_law(const Cursor& entry, Torsions* torsions) {
    torsions->law = entry["law"].choice<TorsionLaw>();
    refuse_numbers_of_other_laws(entry, *torsions);
  }
  static void read(const Cursor& entry, const Context&, Torsions* torsions) {
    for (const Cursor number : entry["coefficients"].optional_list("a list of numbers"))
      torsions->coefficients.push_back(number.number());
    torsions->multiplicity = static_cast<int>(entry["multiplicity"].integer(0, 1000, 1));
  }
};

template std::vector<Force> read_entries(const Cursor&, std::string_view, const Context&);

}  // namespace tanor::scene
