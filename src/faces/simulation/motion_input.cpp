#include "simulation/motion_input.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/text.hpp"
#include "dynamics/decisions.hpp"
#include "dynamics/viscous_friction.hpp"
#include "simulation/stiffness.hpp"
#include "system/enum_check.hpp"
#include "system/members.hpp"
#include "system/one_sided.hpp"

namespace tanor {
using namespace detail;

namespace {

void check_start_time(double t) {
  if (!std::isfinite(t)) throw InputError("", "t_start = " + text(t) + " is not a time");
}

}  // namespace

void detail::check_options(const MotionOptions& options) {
  const auto positive = [](const char* where, double value, const char* rule) {
    if (!(value > 0.0 && std::isfinite(value))) throw InputError(where, text(value) + " is not " + rule);
  };
  check_enum(options.method, methods().back().method, "/motion/method");
  check_enum(options.stabilisation, Stabilisation::None, "/motion/stabilisation");
  check_enum(options.start, StartMode::Project, "/motion/start");
  if (options.step != 0.0) positive("/motion/step", options.step, "a positive step, s");
  if (options.max_step != 0.0) positive("/motion/max_step", options.max_step, "a positive longest step, s");
  positive("/motion/rtol", options.rtol, "a positive tolerance");
  if (options.atol != 0.0) positive("/motion/atol", options.atol, "a positive tolerance");
  if (options.order != 0 && !(options.order >= 4 && options.order <= ScalarFunction::largest_order)) {
    throw InputError("/motion/order", text(options.order) + " terms; 4 to " + text(ScalarFunction::largest_order) +
                                          " are right, or 0: as the tolerance asks");
  }
  if (!(options.spectral_radius >= 0.0 && options.spectral_radius <= 1.0)) {
    throw InputError("/motion/spectral_radius",
                     texts_apart(std::array{options.spectral_radius, 1.0})[0] + " does not lie between 0 and 1");
  }
}

namespace {

/// Returns a list such as "rk4, dopri5 and dop853".
template <class Serves>
std::string list_methods(const Serves& serves) {
  std::vector<std::string> names;
  for (const MethodTraits& each : methods()) {
    if (each.method != Method::Auto && serves(each)) names.emplace_back(each.name);
  }
  std::string text = names.front();
  for (std::size_t k = 1; k < names.size(); ++k) text += (k + 1 < names.size() ? ", " : " and ") + names[k];
  return text;
}

/// Chooses an implicit method for springs that explicit steps would have to resolve although the motion does not. With
/// a given step their stability decides, otherwise the number of their swings in one of the slow motion.
std::optional<ChosenMethod> choose_for_stiff_springs(const MotionOptions& options, const Stiffness& stiffness) {
  constexpr double stable = 2.0;         // radians a step, the limit of rattle
  constexpr double worthwhile = 1000.0;  // radians in which the slow motion turns by one
  const double rate = stiffness.rate;
  if (options.step > 0.0) {
    if (!(rate * options.step > stable)) return {};
    return ChosenMethod{Method::GeneralizedAlpha,
                        "stiff: " + stiffness.spring + " swings by " + text(rate * options.step) + " radians a step"};
  }
  // The stiff forces may be pair forces, which Newton's matrix does not contain. A trial step tells (StiffSteps).
  const double slow_rate = stiffness.slow_rate();
  if (stiffness.has_pairs || !(slow_rate > 0.0 && rate > worthwhile * slow_rate)) return {};
  return ChosenMethod{Method::Radau5, "stiff: " + stiffness.spring + " swings " + text(rate / slow_rate) +
                                          " times faster than the system falls"};
}

/// Chooses among the methods that serve; `measure` returns the stiffness where implicit ones do.
ChosenMethod choose(const MotionOptions& options, bool in_coordinates, bool may_be_implicit, const auto& measure,
                    const auto& find_obstacle) {
  if (options.method != Method::Auto) return {options.method, ""};
  if (!in_coordinates && may_be_implicit) {
    if (const auto stiff = choose_for_stiff_springs(options, measure())) return *stiff;
  }
  if (options.step > 0.0) {
    if (in_coordinates) return {Method::Rk4, "a step is given, the motion is in coordinates"};
    return {Method::Rattle, "a step is given: one solve each, and energy that does not drift"};
  }
  const std::string obstacle = find_obstacle();
  if (obstacle.empty()) return {Method::Taylor, "all constraints and forces have series in time"};
  return {Method::Dop853, "no series in time: " + obstacle};
}

}  // namespace

ChosenMethod detail::choose_method(const MotionOptions& options, const System& system, Mechanics& mechanics,
                                   bool in_coordinates) {
  const auto measure = [&] { return measure_stiffness(system, mechanics); };
  return choose(options, in_coordinates, mechanics.implicit_formulation() != nullptr, measure, [&] {
    std::string why_not;
    (void)mechanics.series(&why_not);
    return why_not;
  });
}

ChosenMethod choose_method(const MotionOptions& options, const Dynamics& dynamics) {
  const System& system = dynamics.system();
  return choose(
      options, dynamics.plan().form == Form::Tangent, is_friction_viscous(system) && !has_sides(system),
      [&] { return measure_stiffness(system); }, [&] { return dynamics.series_obstacle(); });
}

bool wants_whole_islands(const MotionOptions& options, const System& system) {
  if (options.method != Method::Auto) return traits_of(options.method).is_implicit;
  return is_friction_viscous(system) && !has_sides(system) &&
         choose_for_stiff_springs(options, measure_stiffness(system)).has_value();
}

namespace {

/// Chooses the normal form for rattle and the implicit methods, which need it. `has_equations` is true if some rank has
/// constraints.
SolverOptions resolve(SolverOptions solver, const System& system, bool has_equations, Method method) {
  // The mechanics itself tells whether there are series in time, with the reason.
  if (method == Method::Taylor) return solver;
  const MethodTraits& traits = traits_of(method);
  for (std::size_t k = 0; k < system.friction.size() && !traits.serves_friction; ++k) {
    const bool is_known = traits.is_implicit && std::holds_alternative<Viscous>(system.friction[k]);
    if (is_known || num_contacts(system, k) == 0) continue;
    throw InputError("/motion/method", std::string(traits.name) + " does not know friction (" +
                                           friction_name(system, k) + "); " +
                                           list_methods(std::mem_fn(&MethodTraits::serves_friction)) + " do");
  }
  const auto knows_sides = [](const MethodTraits& each) {
    return !each.is_implicit && each.method != Method::Rattle4 && each.method != Method::Rattle6;
  };
  if (has_sides(system) && !knows_sides(traits)) {
    throw InputError("/motion/method", std::string(traits.name) + " does not know constraints to one side (" +
                                           constraint_name(system, find_one_sided(system)) + "); " +
                                           list_methods(knows_sides) + " do");
  }
  if (has_sides(system) && has_contacts(system) && traits.method == Method::Rattle) {
    throw InputError("/motion/method", std::string(traits.name) + " does not know friction at guides to one side (" +
                                           friction_name(system, 0) + "); dop853 does");
  }
  if (traits.steps_in_coordinates || system.coordinates.empty()) return solver;
  if (solver.form == Form::Tangent || !has_equations) {
    throw InputError("/motion/method",
                     std::string(traits.name) + " projects onto constraints, the tangent form has none; " +
                         list_methods(std::mem_fn(&MethodTraits::steps_in_coordinates)) + " step in coordinates");
  }
  solver.form = Form::Normal;
  return solver;
}

/// Refuses an implicit method where something reaches from rank to rank.
void check_reach(const Part& part, Method method) {
  if (part.is_whole() || !part.is_cut() || !traits_of(method).is_implicit) return;
  const char* const what = part.num_shared_rows > 0     ? "constraints"
                           : part.num_shared_tuples > 0 ? "forces such as springs"
                                                        : "pair forces";
  throw InputError("/motion/method",
                   std::string(what) + " join points of several ranks, over which Newton's matrix of " +
                       std::string(name_of(method)) + " would reach; take fewer ranks, or another method");
}

}  // namespace

SolverOptions detail::check_together(const Part& part, const System& system, const MotionOptions& motion,
                                     const SolverOptions& solver, double t_start) {
  SolverOptions resolved;
  Decisions all(part);
  const bool has_equations = all.any(num_equations(system) > 0);
  (void)all.together([&] {
    check_options(motion);
    check_start_time(t_start);
    validate(system, t_start);
    check_reach(part, motion.method);
    if (has_sides(system) && motion.stabilisation == Stabilisation::None) {
      throw InputError("/motion/stabilisation", constraint_name(system, find_one_sided(system)) +
                                                    " has a side, and its gap would drift without projection");
    }
    if (!part.is_whole()) refuse_sides(system, "this version knows that on one process alone");
    resolved = resolve(solver, system, has_equations, motion.method);
    return Outcome{};
  });
  return resolved;
}

void detail::check_snapshot(const Snapshot& snapshot, std::size_t size) {
  const auto check_finite = [](const char* where, std::span<const double> numbers) {
    const auto bad = std::find_if_not(numbers.begin(), numbers.end(), [](double x) { return std::isfinite(x); });
    if (bad != numbers.end()) throw InputError(where, text(*bad) + " is not a finite number");
  };
  const auto check_points = [&](const char* where, const std::vector<double>& numbers) {
    if (numbers.size() != size) {
      throw InputError(where, "holds " + std::to_string(numbers.size()) + " numbers, the system's points have " +
                                  std::to_string(size));
    }
    check_finite(where, numbers);
  };
  check_points("/snapshot/positions", snapshot.positions);
  check_points("/snapshot/velocities", snapshot.velocities);
  const EnergyReport& energy = snapshot.report.energy;
  check_finite("/snapshot/time", std::array{snapshot.time});
  check_finite("/snapshot/report/energy",
               std::array{energy.start, energy.work_of_supports, energy.work_of_forces, energy.work_of_potentials,
                          energy.work_of_friction, energy.work_of_impacts});
  const auto check_size = [](const char* where, double value) {
    if (!(value >= 0.0 && std::isfinite(value)))
      throw InputError(where, text(value) + " is not 0 or a positive number");
  };
  check_size("/snapshot/next_step", snapshot.next_step);
  check_size("/snapshot/last_error", snapshot.last_error);
  check_finite("/snapshot/event_slopes", snapshot.event_slopes);
  check_finite("/snapshot/memory", snapshot.memory);
  check_finite("/snapshot/drive_memory", snapshot.drive_memory);
  check_finite("/snapshot/rounding_memory", snapshot.rounding_memory);
  check_finite("/snapshot/stiff_memory", snapshot.stiff_memory);
}

}  // namespace tanor
