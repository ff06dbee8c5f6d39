#include "scene/friction.hpp"

#include <optional>

#include "scene/kind.hpp"

namespace tanor::scene {
namespace {

/// "wire" or ["ball", "hoop"]: names of constraints.
std::vector<std::string> read_guides(const Cursor& at) {
  constexpr std::string_view wanted = "the name of a constraint or a list of names";
  if (at.is_string()) return {at.string()};
  std::vector<std::string> names;
  for (const Cursor name : at.list(wanted)) names.push_back(name.string());
  return names;
}

VectorFunction read_velocity(const Cursor& velocity, const Context& context) {
  return velocity ? context.vector_function(velocity) : VectorFunction();
}

/// "exact" (none) or {"regularised": v0}
std::optional<double> read_regularisation(const Cursor& law) {
  if (!law || law.says("exact")) return std::nullopt;
  if (!law.is_object()) law.fail(R"("exact" or {"regularised": v0})");
  return law.object({"regularised"})["regularised"].positive();
}

Friction read_coulomb(const Cursor& entry, const Context& context) {
  Coulomb coulomb;
  coulomb.name = entry["name"].string("");
  coulomb.at = read_guides(entry["at"]);
  coulomb.coefficient = entry["coefficient"].non_negative();
  coulomb.regularisation = read_regularisation(entry["law"]);
  if (const Cursor coefficient = entry["static_coefficient"]) coulomb.static_coefficient = coefficient.non_negative();
  coulomb.velocity = read_velocity(entry["velocity"], context);
  coulomb.reaction = entry["reaction"].choice<Coulomb::Reaction>(coulomb.reaction);
  return coulomb;
}

Friction read_viscous(const Cursor& entry, const Context& context) {
  Viscous viscous;
  viscous.name = entry["name"].string("");
  viscous.at = read_guides(entry["at"]);
  viscous.coefficient = entry["coefficient"].non_negative();
  viscous.velocity = read_velocity(entry["velocity"], context);
  return viscous;
}

const std::vector<Kind<Friction>> kinds = {
    {"coulomb", {"name", "at", "coefficient", "static_coefficient", "law", "velocity", "reaction"}, read_coulomb},
    {"viscous", {"name", "at", "coefficient", "velocity"}, read_viscous},
};

}  // namespace

std::vector<Friction> read_friction(const Cursor& list, const Context& context) {
  std::vector<Friction> friction;
  for (const Cursor entry : list.optional_list("a list of friction laws"))
    friction.push_back(read_kind(entry, kinds, {}, context));
  return friction;
}

}  // namespace tanor::scene
