#include <algorithm>
#include <cmath>
#include <span>
#include <string>
#include <unordered_map>

#include <tanor/system.hpp>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "system/field_checks.hpp"
#include "system/formula_names.hpp"
#include "system/law_numbers.hpp"
#include "system/members.hpp"
#include "system/one_sided.hpp"
#include "system/pair_rules.hpp"
#include "system/tuples.hpp"
#include "system/validate_coordinates.hpp"
#include "system/validate_friction.hpp"

namespace tanor {
using namespace detail;

namespace {

/// One walk over the system in the order of the scene file, which looks at every value once. `where` is the JSON
/// pointer of an entry; the pointers of its members are spelled out only when something is wrong.
class Validation {
 public:
  Validation(const System& system, double t) : system_(system), t_(t) {}

  void run() {
    check_points();
    check_supports();
    check_masses();
    for (std::size_t i = 0; i < system_.constraints.size(); ++i) {
      std::visit([&](const auto& group) { check_group(group, element("/constraints", i)); }, system_.constraints[i]);
    }
    for (std::size_t i = 0; i < system_.forces.size(); ++i) {
      std::visit([&](const auto& force) { check_group(force, element("/forces", i)); }, system_.forces[i]);
    }
    check_names();
    validate_friction(system_, support_of_point_, t_);
    validate_coordinates(system_, support_of_point_, t_);
    refuse_beside_sides();
  }

 private:
  /// Refuses what this version does not know together with constraints to one side.
  void refuse_beside_sides() const {
    const std::size_t g = find_one_sided(system_);
    if (g == system_.constraints.size()) return;
    const std::string beside = "beside " + constraint_name(system_, g) + ", which acts to one side: ";
    if (!system_.coordinates.empty())
      throw InputError("/coordinates", beside + "gaps are watched in positions alone; leave the coordinates out");
    validate_friction_beside_sides(system_, beside);
  }

  // ---- points and supports ----

  void check_points() {
    if (num_points() == 0 && system_.positions.empty()) {
      throw InputError("/points", "there are none; a scene has at least one point");
    }
    check_vectors(system_.positions, "/points/positions", "position");
    if (!system_.velocities.empty()) check_vectors(system_.velocities, "/points/velocities", "velocity");
  }

  /// Throws unless these are 3n numbers in range.
  void check_vectors(std::span<const double> numbers, const std::string& where, const std::string& noun) const {
    if (numbers.size() != 3 * num_points()) {
      throw InputError(where, text_of_count(numbers.size(), "number") + " for " + text_of_count(num_points(), "point") +
                                  "; three numbers for each point are right");
    }
    for (std::size_t i = 0; i < num_points(); ++i) {
      const Vector3 vector = {numbers[3 * i], numbers[3 * i + 1], numbers[3 * i + 2]};
      if (!is_in_range(vector)) check_vector(vector, element(where, i), noun);
    }
  }

  void check_supports() {
    support_of_point_.assign(num_points(), none);
    for (std::size_t i = 0; i < system_.supports.size(); ++i) {
      const Support& support = system_.supports[i];
      const std::string where = element("/supports", i);
      for (std::size_t k = 0; k < support.points.size(); ++k) {
        const Index point = support.points[k];
        check_range(point, where, "points", k);
        std::size_t& owner = support_of_point_[point];
        if (owner != none) {
          throw InputError(element(where + "/points", k), "point " + text(point) + " belongs to " +
                                                              element("/supports", owner) +
                                                              " already; a point has one prescribed motion");
        }
        owner = i;
      }
      check_function(support.displacement, t_, where + "/motion", "displacement");
    }
  }

  /// Masses of supports are ignored, as long as they are numbers.
  void check_masses() const {
    for (std::size_t i = 0; i < num_points(); ++i) {
      const double mass = system_.masses[i];
      const bool is_right = is_in_range(mass) && (mass > 0.0 || is_support(static_cast<Index>(i)));
      if (!is_right) check_number(mass, ValueRange::positive, element("/points/masses", i), "mass");
      if (mass > 0.0 && !is_in_range(1.0 / mass) && !is_support(static_cast<Index>(i)))
        throw InputError(element("/points/masses", i), "mass " + text(mass) + " is below 1e-100");
    }
  }

  // ---- constraints ----

  template <class Group>
  void check_group(const Group& group, const std::string& where) {
    if constexpr (requires { KindOf<Group>::members; }) check_members(group, where);
    check_values(group, where);
  }

  /// Checks the values as the kind's data say. Some kinds have rules of their own, below.
  template <class Group>
  void check_values(const Group& group, const std::string& where) const {
    check_fields(group, t_, where);
    if constexpr (requires { KindOf<Group>::members; }) {
      check_start(system_, group, t_,
                  [&](std::size_t k, const std::string& problem) { fail_member(group, k, where, problem); });
    }
  }

  void check_values(const Linears& linears, const std::string& where) const {
    if (linears.coefficients.empty()) {
      throw InputError(where + "/coefficients", "there are none; a tuple has at least one point");
    }
    for (std::size_t k = 0; k < linears.tuples.size(); ++k) {
      if (linears.tuples[k].empty()) fail_member(linears, k, where, "a tuple has at least one point");
      if (linears.tuples[k].size() != linears.coefficients.size()) {
        throw InputError(element(where + "/tuples", k), text_of_count(linears.tuples[k].size(), "point") + " for " +
                                                            text_of_count(linears.coefficients.size(), "coefficient") +
                                                            "; one for each is right");
      }
    }
    for (std::size_t k = 0; k < linears.coefficients.size(); ++k) {
      const std::string place = element(where + "/coefficients", k);
      check_vector(linears.coefficients[k], place, "coefficient");
      if (const char* complaint = zero_complaint(linears.coefficients[k])) {
        throw InputError(
            place, "coefficient " + text(linears.coefficients[k]) + complaint + "; leave the point out of the tuples");
      }
    }
    check_parameter(linears.value, linears.tuples.size(), ValueRange::any, t_, where + "/value", "value");
    check_number(linears.restitution, restitution_range, where + "/restitution", "restitution");
  }

  void check_values(const Ropes& ropes, const std::string& where) const {
    for (std::size_t k = 0; k < ropes.paths.size(); ++k) {
      const std::size_t segments = ropes.paths[k].size() - 1;
      if (ropes.paths[k].size() < 2) fail_member(ropes, k, where, "a rope has at least 2 points");
      if (!ropes.coefficients.empty() && ropes.coefficients.size() != segments)
        fail_member(ropes, k, where,
                    text_of_count(ropes.coefficients.size(), "coefficient") + " for " +
                        text_of_count(segments, "segment") + "; one for each is right");
      const Index outside = find_first_outside(system_);  // of members that events took out
      if (std::ranges::all_of(ropes.paths[k], [&](Index point) { return is_support(point) && point < outside; }))
        fail_member(ropes, k, where, "all of its points are supports: it holds nothing");
    }
    for (std::size_t c = 0; c < ropes.coefficients.size(); ++c)
      check_number(ropes.coefficients[c], ValueRange::positive, element(where + "/coefficients", c), "coefficient");
    check_fields(ropes, t_, where);
    check_start(system_, ropes, t_,
                [&](std::size_t k, const std::string& problem) { fail_member(ropes, k, where, problem); });
  }

  /// Checks that the function, its derivatives along the initial motion and its gradient are numbers, and the gradient
  /// is not zero.
  void check_values(const UserConstraints& user, const std::string& where) const {
    check_kernel(user.kernel, where);
    check_fields(user, t_, where);
    const auto p = static_cast<std::size_t>(user.kernel.num_points);
    std::vector<Index> points;
    for (std::size_t k = 0; k < user.tuples.size(); ++k) {
      if (user.tuples[k].size() != p) {
        throw InputError(element(where + "/points", k), text_of_count(user.tuples[k].size(), "point") +
                                                            " for a function of " + text_of_count(p, "point"));
      }
      points.insert(points.end(), user.tuples[k].begin(), user.tuples[k].end());
    }
    const std::vector<double> at_rest(system_.velocities.empty() ? system_.positions.size() : 0, 0.0);
    const double* const v = at_rest.empty() ? system_.velocities.data() : at_rest.data();
    for_each_chunk(user.kernel, points, 0, user.tuples.size(), t_, system_.positions.data(), v,
                   [&](const TupleValues& values) {
                     for (std::size_t k = 0; k < values.count; ++k) check_values(user, values, k, where);
                   });
  }

  void check_values(const UserConstraints& user, const TupleValues& values, std::size_t k,
                    const std::string& where) const {
    const std::pair<const char*, double> numbers[] = {
        {"the function", values.xi[k]}, {"its rate", values.rate[k]}, {"its curvature", values.phi[k]}};
    const std::size_t member = values.first + k;
    for (const auto& [noun, number] : numbers) {
      if (!is_in_range(number)) fail_member(user, member, where, noun + (" is " + text(number)) + " at the start");
    }
    const double* const gradient = values.gradient + k * values.size;
    for (std::size_t i = 0; i < values.size; ++i) {
      if (!is_in_range(gradient[i])) {
        fail_member(user, member, where, "its gradient has the component " + text(gradient[i]) + " at the start");
      }
    }
    if (!(largest_block(gradient, values.size) > 0.0)) {
      fail_member(user, member, where, "its gradient is zero at the start: it holds nothing there");
    }
  }

  static void check_kernel(const ConstraintKernel& kernel, const std::string& where) {
    if (kernel.evaluate == nullptr) throw InputError(where + "/equation", "is missing: there is no function to call");
    if (kernel.num_points < 1 || kernel.num_points > ConstraintKernel::most_points) {
      throw InputError(where + "/equation", "a function of " + text_of_count(kernel.num_points, "point") + "; 1 to " +
                                                text(ConstraintKernel::most_points) + " are right");
    }
  }

  // ---- forces ----

  void check_values(const FormulaForce& force, const std::string& where) const {
    if (force.kernel.evaluate == nullptr) throw InputError(where + "/x", "is missing: there is no function to call");
    const std::vector<double> at_rest(3, 0.0);
    if (force.kernel.num_points < 1 || force.kernel.num_points > ForceKernel::most_points)
      throw InputError(where + "/tuples", "a force on " + text_of_count(force.kernel.num_points, "point") + "; 1 to " +
                                              text(ForceKernel::most_points) + " are right");
    check_tuples(force, where);
    if (force.kernel.num_points > 1 && !force.points.empty())
      throw InputError(where + "/points", "a force on tuples of " + text(force.kernel.num_points) +
                                              " points is given single ones; leave them out");
    for (std::size_t k = 0; k < force.points.size(); ++k) {
      const auto first = 3 * static_cast<std::size_t>(force.points[k]);
      const double* const v = system_.velocities.empty() ? at_rest.data() : &system_.velocities[first];
      Vector3 f{};
      force.kernel.evaluate(force.kernel.context.get(), {1, t_, &system_.positions[first], v, f.data()});
      if (!is_in_range(f)) fail_member(force, k, where, "the force is " + text(f) + " at the start");
    }
  }

  void check_tuples(const FormulaForce& force, const std::string& where) const {
    const auto p = static_cast<std::size_t>(force.kernel.num_points);
    for (std::size_t k = 0; k < force.tuples.size(); ++k) {
      const std::span<const Index> tuple = force.tuples[k];
      const auto fail = [&](const std::string& problem) {
        throw InputError(element(where + "/tuples", k), text(tuple) + ": " + problem);
      };
      if (tuple.size() != p)
        fail(text_of_count(tuple.size(), "point") + " for a force on " + text_of_count(p, "point"));
      std::vector<double> r, v;
      for (std::size_t i = 0; i < p; ++i) {
        check_range(tuple[i], where, "tuples", k);
        if (std::ranges::count(tuple, tuple[i]) > 1)
          fail("names point " + text(tuple[i]) + " twice; the points of a tuple differ");
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::size_t at = 3 * static_cast<std::size_t>(tuple[i]) + axis;
          r.push_back(system_.positions[at]);
          v.push_back(system_.velocities.empty() ? 0.0 : system_.velocities[at]);
        }
      }
      std::vector<double> f(3 * p);
      force.kernel.evaluate(force.kernel.context.get(), {1, t_, r.data(), v.data(), f.data()});
      for (const double component : f) {
        if (!is_in_range(component)) fail("the force is " + text(std::span<const double>(f)) + " at the start");
      }
    }
  }

  void check_values(const PairForces& pairs, const std::string& where) const {
    check_pair_rules(
        system_, pairs, [this](Index point) { return is_support(point); }, where);
  }

  // ---- energies ----

  /// Checks that the energy and its gradient are numbers at the start, and that some point of each tuple moves.
  void check_values(const Potential& group, const std::string& where) const {
    const PotentialKernel& kernel = group.kernel;
    if (kernel.evaluate == nullptr) throw InputError(where + "/energy", "is missing: there is no function to call");
    if (kernel.num_points < 1 || kernel.num_points > PotentialKernel::most_points)
      throw InputError(where + "/energy", "an energy of " + text_of_count(kernel.num_points, "point") + "; 1 to " +
                                              text(PotentialKernel::most_points) + " are right");
    check_constants(group, where);
    const auto p = static_cast<std::size_t>(kernel.num_points);
    for (std::size_t k = 0; k < group.points.size(); ++k) {
      if (group.points[k].size() != p)
        fail_member(group, k, where,
                    text_of_count(group.points[k].size(), "point") + " for an energy of " + text_of_count(p, "point"));
      check_tuple_moves(group, k, where);
      std::vector<double> r, numbers, gradient(3 * p);
      for (const Index point : group.points[k]) {
        for (std::size_t axis = 0; axis < 3; ++axis)
          r.push_back(system_.positions[3 * static_cast<std::size_t>(point) + axis]);
      }
      for (const auto& each : group.constants) numbers.push_back(each[each.size() == 1 ? 0 : k]);
      double energy = 0.0;
      kernel.evaluate(kernel.context.get(), {1, t_, r.data(), numbers.data(), &energy, gradient.data()});
      // The text of the energy, which all tuples share, is what may be wrong. So the error names its entry.
      const auto fail = [&](const std::string& problem) {
        throw InputError(where,
                         name_member(group, k) + ": " + problem + " at the start; finite, at most 1e100, is right");
      };
      if (!is_in_range(energy)) fail("the energy is " + text(energy));
      for (const double slope : gradient) {
        if (!is_in_range(slope)) fail("the gradient of the energy has the component " + text(slope));
      }
    }
  }

  static void check_constants(const Potential& group, const std::string& where) {
    if (group.constants.size() != static_cast<std::size_t>(group.kernel.num_constants))
      throw InputError(where + "/constants", text_of_count(group.constants.size(), "constant") + " for a function of " +
                                                 text(group.kernel.num_constants));
    for (const auto& each : group.constants) {
      if (each.size() != 1 && each.size() != group.points.size())
        throw InputError(where + "/constants", text_of_count(each.size(), "number") + " for " +
                                                   text_of_count(group.points.size(), "tuple") +
                                                   "; one for all or one each is right");
      for (const double number : each) check_number(number, ValueRange::any, where + "/constants", "constant");
    }
  }

  template <class Group>
  void check_tuple_moves(const Group& group, std::size_t k, const std::string& where) const {
    const std::span<const Index> points = member_points(group, k);
    // A user's energy of points that prestress turns out to hold is no mistake.
    const auto is_given = [this](Index point) {
      return is_support(point) && system_.supports[support_of_point_[point]].name != rigid_points_name;
    };
    if (std::ranges::all_of(points, is_given))
      fail_member(group, k, where, "all of its points are supports: its energy moves nothing");
  }

  /// Checks built-in energies: the numbers that the law reads are there, and the law is defined where the points are.
  template <HasEnergy Group>
  void check_values(const Group& group, const std::string& where) const {
    check_fields(group, t_, where);
    for (const LawNumber& number : KindOf<Group>::law_numbers(group)) {
      if (number.value->is_initial() && !number.may_be_initial)
        throw InputError(where + "/" + number.name, "is missing, and the law reads it");
    }
    if constexpr (std::is_same_v<Group, Torsions>) check_torsions(group, where);
    for (std::size_t k = 0; k < num_members(group); ++k) {
      check_tuple_moves(group, k, where);
      const std::string problem =
          KindOf<Group>::complaint(group, start_places(system_, group, k), law_numbers_of(system_, group, k));
      if (!problem.empty()) fail_member(group, k, where, problem);
    }
  }

  static void check_torsions(const Torsions& torsions, const std::string& where) {
    const std::string place = where + "/coefficients";
    if (torsions.law == TorsionLaw::Opls && torsions.coefficients.size() != 4)
      throw InputError(place, text_of_count(torsions.coefficients.size(), "coefficient") + "; law opls has four");
    if (torsions.law == TorsionLaw::Multi && torsions.coefficients.empty())
      throw InputError(place, "there are none; law multi has at least c0");
    for (const double number : torsions.coefficients) check_number(number, ValueRange::any, place, "coefficient");
    for (const LawNumber& number : KindOf<Torsions>::law_numbers(torsions)) {
      constexpr double turn = 6.4;
      if (number.value != &torsions.phase && number.value != &torsions.rest) continue;
      for (const double angle : number.value->constants) {
        if (std::abs(angle) > turn)
          throw InputError(where + "/" + number.name, std::string(number.name) + " " + text(angle) +
                                                          " is more than a whole turn: rad, not degrees?");
      }
    }
    if (torsions.multiplicity < 0)
      throw InputError(where + "/multiplicity", "multiplicity " + text(torsions.multiplicity) + " is negative");
  }

  // ---- members ----

  /// Checks that points are in range, and none is twice in a member.
  template <class Group>
  void check_members(const Group& group, const std::string& where) {
    if (last_member_of_point_.empty()) last_member_of_point_.assign(num_points(), none);
    for (std::size_t k = 0; k < num_members(group); ++k, ++num_members_seen_) {
      for (const Index point : member_points(group, k)) {
        check_range(point, where, list_name<Group>(), k);
        std::size_t& last_member = last_member_of_point_[point];
        if (last_member == num_members_seen_) {
          if constexpr (requires { KindOf<Group>::distinct; }) {
            throw InputError(
                element(where + "/" + list_name<Group>(), k),
                text(member_points(group, k)) + " names point " + text(point) + " twice; " + KindOf<Group>::distinct);
          }
        }
        last_member = num_members_seen_;
      }
    }
  }

  void check_range(Index point, const std::string& where, const char* list, std::size_t k) const {
    if (0 <= point && static_cast<std::size_t>(point) < num_points()) return;
    throw InputError(element(where + "/" + list, k),
                     "point " + text(point) + " is out of range: the scene has " +
                         text_of_count(num_points(), "point") +
                         (num_points() == 1 ? ", 0" : ", 0 to " + text(num_points() - 1)));
  }

  /// Returns "[4, 5]" or "point 4".
  template <class Group>
  static std::string name_member(const Group& group, std::size_t k) {
    const std::span<const Index> points = member_points(group, k);
    return points.size() == 1 ? "point " + text(points[0]) : text(points);
  }
  template <class Group>
  [[noreturn]] static void fail_member(const Group& group, std::size_t k, const std::string& where,
                                       const std::string& problem) {
    throw InputError(element(where + "/" + list_name<Group>(), k), name_member(group, k) + ": " + problem);
  }

  // ---- names ----

  void check_names() const {
    std::unordered_map<std::string, std::string> owners;  // name -> JSON pointer
    check_name(system_.name, "/name");
    for (std::size_t i = 0; i < system_.supports.size(); ++i) {
      if (system_.supports[i].name != outside_name)
        check_name(system_.supports[i].name, element("/supports", i) + "/name");
    }
    const auto add = [&](const std::string& name, const std::string& where) {
      if (!name.starts_with('\x1f')) check_name(name, where + "/name");  // so hosts name what has no name
      const auto [owner, is_new] = owners.emplace(name, where);
      if (!is_new) {
        throw InputError(where + "/name",
                         "\"" + name + "\" is the name of " + owner->second + " already; a name is used once");
      }
    };
    for (std::size_t i = 0; i < system_.constraints.size(); ++i)
      add(constraint_name(system_, i), element("/constraints", i));
    // Constraint 0, force 0 and friction 0 may all be a "formula0" by default.
    const auto add_unless_default = [&](const auto& entry, const std::string& name, const std::string& where) {
      const bool is_own = std::visit([](const auto& group) { return !group.name.empty(); }, entry);
      const auto owner = owners.find(name);
      const std::string list = where.substr(0, where.rfind('/'));
      if (is_own || owner == owners.end() || owner->second.starts_with(list)) add(name, where);
    };
    for (std::size_t i = 0; i < system_.forces.size(); ++i)
      add_unless_default(system_.forces[i], force_name(system_, i), element("/forces", i));
    for (std::size_t i = 0; i < system_.friction.size(); ++i)
      add_unless_default(system_.friction[i], friction_name(system_, i), element("/friction", i));
  }

  // ---- the system ----

  std::size_t num_points() const { return system_.num_points(); }
  bool is_support(Index point) const { return support_of_point_[point] != none; }

  static constexpr std::size_t none = no_support;

  const System& system_;
  const double t_;
  std::vector<std::size_t> support_of_point_;      ///< [point] -> its support or none
  std::vector<std::size_t> last_member_of_point_;  ///< [point] -> the last member that named it, or none
  std::size_t num_members_seen_ = 0;
};

}  // namespace

void validate(const System& system, double t) {
  Validation(system, t).run();
}

}  // namespace tanor
