#include "system/validate_friction.hpp"

#include <map>
#include <string>
#include <unordered_map>

#include "base/text.hpp"
#include "system/contacts.hpp"
#include "system/enum_check.hpp"
#include "system/field_checks.hpp"
#include "system/members.hpp"
#include "system/validate_coordinates.hpp"

namespace tanor::detail {

namespace {

constexpr int most_guide_equations = 2;  // for one point: a wire; three hold it in place

template <class Group>
bool guides_single_points(const Group& group) {
  if constexpr (std::is_same_v<Group, UserConstraints>)
    return group.kernel.num_points == 1;
  else
    return has_single_points<Group>;
}

/// Returns "a plane, sphere, … or formula of single points", the kinds that can be a guide.
template <class... Groups>
std::string list_guides(const std::variant<Groups...>*) {
  std::string list = "a";
  const auto append = [&]<class Group>(const Group*) {
    if (has_single_points<Group>) list += (list == "a" ? " " : ", ") + std::string(KindOf<Group>::name);
  };
  (append(static_cast<const Groups*>(nullptr)), ...);
  return list + " or formula of single points";
}

/// One walk over the entries, in the order of the scene file.
class FrictionValidation {
 public:
  FrictionValidation(const System& system, std::span<const std::size_t> support_of_point, double t)
      : system_(system), support_of_point_(support_of_point), t_(t) {
    for (std::size_t g = 0; g < system.constraints.size(); ++g) group_of_name_.emplace(constraint_name(system, g), g);
  }

  void run() {
    for (std::size_t i = 0; i < system_.friction.size(); ++i) {
      const std::string where = element("/friction", i);
      std::visit(
          [&](const auto& friction) {
            check_guides(friction.at, where + "/at");
            if (law_sticks(system_.friction[i])) claim_guides(friction.at, where);
            check_fields(friction, t_, where);
            check_values(friction, where);
          },
          system_.friction[i]);
    }
  }

 private:
  // ---- guides ----

  /// Checks that each name is that of a guide, and that every point it guides keeps at least one direction to slide in.
  void check_guides(const std::vector<std::string>& at, const std::string& where) {
    if (at.empty()) throw InputError(where, "is empty; it names the constraints that the friction acts at");
    equations_of_point_.clear();
    std::unordered_map<std::string, std::size_t> places;
    for (std::size_t k = 0; k < at.size(); ++k) {
      const std::size_t group = find_guide(at[k], element(where, k));
      const auto [first, is_new] = places.emplace(at[k], k);
      if (!is_new) {
        throw InputError(element(where, k), quoted(at[k]) + " is named by " + element(where, first->second) +
                                                " already; a guide is named once");
      }
      std::visit([&](const auto& guide) { add_guide(guide, at[k], element(where, k)); }, system_.constraints[group]);
    }
  }

  std::size_t find_guide(const std::string& name, const std::string& where) const {
    if (system_.constraints.empty()) {
      throw InputError(where, quoted(name) + " names no constraint: there are none, and coordinates are no guides; " +
                                  wanted + " is right");
    }
    const auto found = group_of_name_.find(name);
    if (found == group_of_name_.end()) {
      throw InputError(where, quoted(name) + " is the name of no constraint; " + wanted + " is right");
    }
    const Constraint& constraint = system_.constraints[found->second];
    if (!std::visit([](const auto& group) { return guides_single_points(group); }, constraint)) {
      throw InputError(
          where, quoted(name) + " is of kind " + std::string(kind_name(constraint)) + "; " + wanted + " is right");
    }
    return found->second;
  }

  /// Throws if two laws with stick name one guide, since they could share the force that holds a point in any way.
  void claim_guides(const std::vector<std::string>& at, const std::string& where) {
    for (std::size_t k = 0; k < at.size(); ++k) {
      const auto [owner, is_new] = sticking_entry_of_guide_.emplace(at[k], where);
      if (!is_new) {
        throw InputError(element(where + "/at", k), "points stick at " + quoted(at[k]) + " by " + owner->second +
                                                        " already; give one entry with the sum of the coefficients");
      }
    }
  }

  template <class Group>
  void add_guide(const Group& guide, const std::string& name, const std::string& where) {
    for (std::size_t k = 0; k < num_members(guide); ++k) {
      const Index point = member_points(guide, k).front();
      if (support_of_point_[static_cast<std::size_t>(point)] != no_support) continue;
      int& equations = equations_of_point_[point];
      equations += rows_per_member<Group>();
      if (equations > most_guide_equations) {
        throw InputError(where, "with " + quoted(name) + " point " + text(point) + " has " +
                                    text_of_count(static_cast<std::size_t>(equations), "equation") +
                                    " and cannot slide; 1 (a surface) or 2 (a wire) are right");
      }
    }
  }

  // ---- laws ----

  /// The context of a law's own check (KindOf<Law>::check). `key` is the end of a JSON pointer.
  struct LawCheck {
    const std::string& where;

    /// Throws. `parts` are texts and numbers, one after the other.
    template <class... Parts>
    [[noreturn]] void fail(const char* key, const Parts&... parts) const {
      throw InputError(where + key, (... + in_words(parts)));
    }
    void number(const char* key, const char* noun, double value, const ValueRange& range) const {
      check_number(value, range, where + key, noun);
    }
    template <class Enum>
    void choice(const char* key, Enum value, Enum last) const {
      check_enum(value, last, (where + key).c_str());
    }

   private:
    static std::string in_words(const char* part) { return part; }
    static std::string in_words(double part) { return text(part); }
  };

  template <class Law>
  void check_values(const Law& law, const std::string& where) const {
    if constexpr (requires { KindOf<Law>::check(law, LawCheck{where}); }) KindOf<Law>::check(law, LawCheck{where});
    if constexpr (requires { KindOf<Law>::num_multipliers(law); }) {
      const int wanted_multipliers = KindOf<Law>::num_multipliers(law);
      for (const auto& [point, equations] : equations_of_point_) {
        if (equations == wanted_multipliers) continue;
        throw InputError(where + "/law", "a law of " + plural(wanted_multipliers, "multiplier") + ", and point " +
                                             text(point) + " has " + plural(equations, "guide equation") +
                                             "; one multiplier for each is right");
      }
    }
  }

  static std::string plural(int count, const std::string& noun) {
    return text(count) + " " + noun + (count == 1 ? "" : "s");
  }
  static std::string quoted(const std::string& name) { return "\"" + name + "\""; }

  const std::string wanted = list_guides(static_cast<const Constraint*>(nullptr));
  const System& system_;
  const std::span<const std::size_t> support_of_point_;
  const double t_;
  std::unordered_map<std::string, std::size_t> group_of_name_;
  std::unordered_map<std::string, std::string> sticking_entry_of_guide_;  ///< JSON pointers of laws that stick
  std::map<Index, int> equations_of_point_;  ///< [moving point] equations of the present entry's guides
};

}  // namespace

void validate_friction(const System& system, std::span<const std::size_t> support_of_point, double t) {
  if (!system.friction.empty()) FrictionValidation(system, support_of_point, t).run();
}

/// Returns the friction of a law that sticks over |N| where it slides.
static double coefficient_of_sliding(const Friction& friction) {
  const auto ask = []<class Law>(const Law& law) {
    if constexpr (requires { KindOf<Law>::static_coefficient(law); }) return KindOf<Law>::magnitude(law, 0.0, 1.0);
    return 0.0;
  };
  return std::visit(ask, friction);
}

void validate_friction_beside_sides(const System& system, const std::string& beside) {
  std::vector<char> is_one_sided;  // [user's row]
  for (const Constraint& constraint : system.constraints) {
    const auto [members, rows] = shape_of(constraint);
    const bool has_side = std::visit(
        [](const auto& group) {
          if constexpr (requires { group.side; }) return group.side.has_value();
          return false;
        },
        constraint);
    is_one_sided.insert(is_one_sided.end(), members * rows, has_side ? 1 : 0);
  }
  for (const Contact& contact : list_contacts(system)) {
    const auto f = static_cast<std::size_t>(contact.friction);
    const std::string where = element("/friction", f), name = friction_name(system, f) + " ";
    if (is_one_sided[static_cast<std::size_t>(contact.guide_rows.front())] == 0 || contact.guide_rows.size() > 1) {
      throw InputError(where + "/at", beside + name +
                                          (contact.guide_rows.size() > 1
                                               ? "joins two guides of one point; "
                                                 "give each of them a law of its own"
                                               : "acts at a guide to both sides; this version knows friction at "
                                                 "guides to one side there"));
    }
    const Friction& law = system.friction[f];
    if (!law_sticks(law) || reads_full_reaction(law)) {
      throw InputError(where, beside + name +
                                  "is not Coulomb's exact law with the reaction of its guide, the only one "
                                  "that this version knows at a gap");
    }
    if (static_coefficient_of(law) != coefficient_of_sliding(law))
      throw InputError(where + "/static_coefficient",
                       beside + name + "has a static coefficient of its own; leave it out");
  }
}

}  // namespace tanor::detail
