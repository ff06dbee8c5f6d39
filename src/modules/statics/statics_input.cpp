#include "statics/statics_input.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <tanor/warnings.hpp>

#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "evaluate/pair_stiffness.hpp"
#include "statics/equilibrium_equations.hpp"
#include "system/enum_check.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

void check_options(const EquilibriumOptions& options) {
  check_enum(options.method, EquilibriumMethod::Descent, "/equilibrium/method");
  check_enum(options.accept, AcceptedEquilibria::Any, "/equilibrium/accept");
  const auto check_positive = [](double value, const char* where) {
    if (!(value > 0.0) || !std::isfinite(value))
      throw InputError(where, "found " + text(value) + ", wanted a positive number");
  };
  check_positive(options.force_tolerance, "/equilibrium/force_tolerance");
  check_positive(options.max_iterations, "/equilibrium/max_iterations");
  check_positive(options.load_steps, "/equilibrium/load_steps");
  if (!std::isfinite(options.at)) throw InputError("/equilibrium/at", text(options.at) + " is not a time");
}

void leave_out_friction(System* system, bool ignore, std::vector<std::string>* left_out) {
  for (std::size_t k = 0; k < system->friction.size(); ++k) {
    const std::string name = friction_name(*system, k), kind(kind_name(system->friction[k]));
    if (!std::holds_alternative<Viscous>(system->friction[k]) && !ignore)
      throw InputError("/friction/" + std::to_string(k),
                       name + " of kind " + kind + ": with friction a system rests in many places; " +
                           R"("friction": "ignore" in /equilibrium finds where it rests without)");
    left_out->push_back(name + ": friction (" + kind + ") takes no part in an equilibrium");
  }
  system->friction.clear();
}

void leave_out_coordinates(System* system, std::vector<std::string>* left_out) {
  if (system->coordinates.empty()) return;
  if (system->constraints.empty())
    throw InputError("/coordinates",
                     "an equilibrium is found with constraints: the same motion as /constraints is wanted");
  left_out->push_back("coordinates: the constraints say the same");
  system->coordinates.clear();
}

/// Refuses, or with `ignores_stability` notes, forces that have no stiffness. Without it neither stability nor
/// vibrations are known.
void require_stiffness(const System& system, bool ignores_stability, std::vector<std::string>* left_out) {
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const auto* const pairs = std::get_if<PairForces>(&system.forces[k]);
    if (pairs == nullptr || has_stiffness(system, *pairs)) continue;
    const std::string name = force_name(system, k);
    if (!ignores_stability)
      throw InputError("/forces/" + std::to_string(k),
                       name + ": " + text(num_points(system, *pairs)) + " points all interact, and a stiffness of " +
                           text(bytes_of_dense_stiffness(num_points(system, *pairs))) +
                           " bytes would say whether they are stable and how they vibrate; up to " +
                           text(most_points_of_dense_stiffness) +
                           " points have one. \"accept\": \"any\" in /equilibrium finds where the system rests");
    left_out->push_back(name + ": it has no part in the stiffness; the status says what is without it");
  }
}

/// Returns the tensions of named rods as multipliers, lambda = -T.
std::vector<double> read_prestress(const System& system, const std::vector<Prestress>& prestress) {
  std::vector<double> result(num_equations(system), 0.0);
  for (std::size_t k = 0; k < prestress.size(); ++k) {
    const std::string where = "/equilibrium/prestress/" + prestress[k].rods;
    bool is_found = false;
    std::size_t row = 0;
    for (std::size_t g = 0; g < system.constraints.size(); ++g) {
      const auto [members, rows] = shape_of(system.constraints[g]);
      if (constraint_name(system, g) == prestress[k].rods && std::holds_alternative<Rods>(system.constraints[g])) {
        is_found = true;
        const std::vector<double>& tensions = prestress[k].tensions;
        if (tensions.size() != 1 && tensions.size() != members)
          throw InputError(where, text_of_count(tensions.size(), "tension") + " for " + text_of_count(members, "rod") +
                                      "; one for all or one each is right");
        for (std::size_t i = 0; i < members; ++i) {
          const double tension = tensions[tensions.size() == 1 ? 0 : i];
          if (!std::isfinite(tension)) throw InputError(where, "a tension is not finite");
          result[row + i] = -tension;
        }
      }
      row += members * rows;
    }
    if (!is_found) throw InputError(where, "no constraint of kind rod has the name \"" + prestress[k].rods + "\"");
  }
  return result;
}

}  // namespace

StaticsInput::StaticsInput(const System& given, const EquilibriumOptions& options) : system(given) {
  check_options(options);
  validate(system, options.at);
  if (std::ranges::any_of(system.velocities, [](double v) { return v != 0.0; }))
    left_out.push_back("velocities: an equilibrium is at rest");
  system.velocities.clear();
  leave_out_friction(&system, options.ignore_friction, &left_out);
  leave_out_coordinates(&system, &left_out);
  for (std::string& warning : find_warnings(system)) left_out.push_back(std::move(warning));
  require_stiffness(system, options.accept == AcceptedEquilibria::Any, &left_out);
  prestress = read_prestress(system, options.prestress);
  enter_frame(options);
}

/// Takes what depends on time as it is, if that is asked for, or finds the frame in which it rests.
void StaticsInput::enter_frame(const EquilibriumOptions& options) {
  if (options.freeze_time) {
    for (const std::string& name : list_what_depends_on_time(system))
      left_out.push_back(name + ": the motion is frozen at t = " + text(options.at));
    return;
  }
  frame = find_steady_frame(system, options.at);
  if (!frame.moves()) return;
  add_inertia(frame, &system);
  left_out.push_back("rest: in the frame " + frame.describe() + ", with the energy of its inertia");
}

void note_useless_prestress(const std::vector<double>& prestress, std::size_t self_stress_states,
                            std::vector<std::string>* left_out) {
  const bool is_given = std::ranges::any_of(prestress, [](double tension) { return tension != 0.0; });
  if (is_given && self_stress_states == 0)
    left_out->push_back("prestress: the rods cannot pull against each other, the forces alone decide their tensions");
}

void note_changed_prestress(const EquilibriumEquations& equations, const std::vector<double>& given,
                            const std::vector<double>& found, std::vector<std::string>* left_out) {
  constexpr double digits = 1e-6;  // accuracy to which tensions are given
  const auto largest = [](const std::vector<double>& x) {
    double result = 0.0;
    for (const double each : x) result = larger(result, std::abs(each));
    return result;
  };
  const double allowed = digits * largest(given);
  if (allowed == 0.0) return;
  // K lambda, and f + K lambda
  std::vector<double> left(equations.size(), 0.0), sum(equations.size());
  equations.add_reactions(given.data(), left.data());
  for (std::size_t i = 0; i < sum.size(); ++i) sum[i] = left[i] + equations.forces()[i];
  if (largest(left) <= allowed || largest(sum) <= allowed) return;
  std::size_t worst = given.size();
  for (std::size_t a = 0; a < given.size(); ++a) {
    if (given[a] == 0.0) continue;
    if (worst == given.size() || !(std::abs(found[a] - given[a]) <= std::abs(found[worst] - given[worst]))) worst = a;
  }
  const Model& model = equations.model();
  const std::string& unit = model.system.units.force;
  left_out->push_back(
      "prestress: the rods do not balance with it, and the tensions that come nearest to it take its "
      "place: that of " +
      equation_name(model.system, static_cast<std::size_t>(model.numbering.user_row[worst])) + " is " +
      with_unit(text(-found[worst]), unit) + " where " + with_unit(text(-given[worst]), unit) + " is asked for");
}

std::string describe_rigid_points(const std::vector<Index>& points) {
  return text_of_count(points.size(), "point") + " from point " + std::to_string(std::ranges::min(points)) +
         " on: held rigid by prestress between supports, the tension of their rods is not determined";
}

std::string name_some(const std::vector<std::string>& all, const char* separator, const char* rest) {
  constexpr std::size_t most = 3;
  std::string names;
  for (std::size_t k = 0; k < std::min(most, all.size()); ++k) names += (k > 0 ? separator : "") + all[k];
  return all.size() > most ? names + rest + std::to_string(all.size() - most) + " more" : names;
}

System with_load(const System& system, double factor, double t) {
  System result = system;
  for (Force& force : result.forces) {
    if (auto* gravity = std::get_if<Gravity>(&force)) {
      for (double& a : gravity->acceleration) a *= factor;
    } else if (auto* constant = std::get_if<ConstantForce>(&force)) {
      const std::array<Jet<2>, 3> now = constant->force(t);
      constant->force = Vector3{factor * now[0].value(), factor * now[1].value(), factor * now[2].value()};
    }
  }
  return result;
}

}  // namespace tanor::detail
