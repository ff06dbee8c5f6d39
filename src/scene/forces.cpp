#include <fmt/format.h>

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

template std::vector<Force> read_entries(const Cursor&, std::string_view, const Context&);

}  // namespace tanor::scene
