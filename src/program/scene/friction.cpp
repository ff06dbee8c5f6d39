#include "scene/kind.hpp"

namespace tanor::scene {
std::vector<std::string> read_guides(const Cursor& at) {
  constexpr std::string_view wanted = "the name of a constraint or a list of names";
  if (at.is_string()) return {at.string()};
  std::vector<std::string> names;
  for (const Cursor name : at.list(wanted)) names.push_back(name.string());
  return names;
}

template <>
struct Extra<Coulomb> {
  static constexpr std::array<std::string_view, 7> keys{"name", "at",       "coefficient", "static_coefficient",
                                                        "law",  "velocity", "reaction"};
  /// Reads "law": "exact" (default) or {"regularised": v0}.
  static void read(const Cursor& entry, const Context&, Coulomb* coulomb) {
    const Cursor law = entry["law"];
    if (law && !law.says("exact")) {
      if (!law.is_object()) law.fail(R"("exact" or {"regularised": v0})");
      coulomb->regularisation = law.object({"regularised"})["regularised"].positive();
    }
    coulomb->reaction = entry["reaction"].choice<Coulomb::Reaction>(coulomb->reaction);
  }
};

/// A user's own law has no text form.
template <>
struct Extra<UserFriction> {
  static constexpr bool is_left_out = true;
};

template std::vector<Friction> read_entries(const Cursor&, std::string_view, const Context&);

}  // namespace tanor::scene
