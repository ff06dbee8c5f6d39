#include <tanor/dynamics.hpp>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include <span>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/kinds.hpp"
#include "python/records.hpp"

/// \file
/// Rest and small vibrations: find_equilibrium, modes, find_buckling.
namespace tanor::python {
namespace {

template <class Options>
Options read_options(const char* what, py::object options, py::object solver, const py::kwargs& named,
                     const py::object& system) {
  take_named_options<Options>(what, system, named, &options, &solver);
  auto chosen = choose_options<Options>(options, system);
  chosen.solver = choose_options<SolverOptions>(solver, system);
  return chosen;
}

/// Returns the positions that the user gave, or those of the description.
std::vector<double> positions_of(const System& system, const py::object& positions) {
  if (positions.is_none()) return system.positions;
  return PackedNumbers(positions, {"positions", static_cast<py::ssize_t>(system.num_points())}).copy();
}

py::object rest(const py::object& object, const py::object& options, const py::object& solver,
                const py::kwargs& named) {
  const System system = read_system(object);
  const auto chosen = read_options<EquilibriumOptions>("find_equilibrium", options, solver, named, object);
  const std::vector<Observable> wanted = choose_observables(object, system);
  const EquilibriumResult found = without_lock([&] { return find_equilibrium(system, chosen); });
  const Solution state = state_at_rest(found, chosen.at);
  // A search that failed knows places and no forces.
  const auto see = [&](const std::vector<Observable>& these) {
    return found.positions.empty() ? std::vector<Observed>{} : observe(system, these, state);
  };
  py::object result = keep(found, object, system, see(tensions_of_groups(system)));
  if (!found.positions.empty()) result.attr("__dict__")["state"] = state;
  result.attr("__dict__")["observables"] = see(wanted);
  return result;
}

/// Reads flags [equations], or no flag for None.
std::vector<bool> flags_to_read(const py::object& flags) {
  if (flags.is_none()) return {};
  const py::array_t<bool, py::array::c_style | py::array::forcecast> given(flags);
  return std::vector<bool>(given.data(), given.data() + given.size());
}

/// Returns the state of what is held about which modes swing.
Solution state_between(System held, std::span<const double> at, const ModesOptions& options, const Modes& found) {
  held.friction.clear();
  held.velocities.clear();
  Solution state = Dynamics(held, options.solver).solution({options.time, at});
  state.velocities.resize(at.size());
  if (!found.multipliers.empty()) {
    state.multipliers = found.multipliers;
    state.has_prestress =
        found.outcome.ok() && std::ranges::any_of(state.multipliers, [](double each) { return std::isnan(each); });
    state.reactions = found.reactions;
    state.support_forces = found.support_forces;
  }
  if (!options.prestress.empty()) state.self_stress.clear();
  return state;
}

/// Gives numbers of the rows of all constraints, of which those that are open pull with nothing.
void spread(std::vector<double>* rows, const std::vector<bool>& open) {
  if (open.empty() || rows->empty()) return;
  const std::vector<double> held = std::exchange(*rows, std::vector<double>(open.size()));
  for (std::size_t row = 0, next = 0; row < open.size(); ++row)
    if (!open[row]) (*rows)[row] = held[next++];
}

py::object vibrate(const py::object& object, const py::object& positions, const py::object& options,
                   const py::object& multipliers, const py::object& open_rows, const py::object& solver,
                   const py::kwargs& named) {
  const System system = read_system(object);
  const std::vector<bool> open = flags_to_read(open_rows);
  const System held = without_open_constraints(system, open);
  auto chosen = read_options<ModesOptions>("modes", options, solver, named, object);
  const std::vector<double> at = positions_of(system, positions);
  const PackedNumbers given(multipliers, {"multipliers", static_cast<py::ssize_t>(num_equations(system)), 0});
  for (std::size_t row = 0; row < given.span().size(); ++row) {
    if (open.empty() || !open[row]) chosen.multipliers.push_back(given.span()[row]);
  }
  Modes found = without_lock([&] { return modes(held, at, chosen); });
  std::vector<Observed> tensions, observed;
  Solution state;
  if (found.outcome.ok()) {
    state = without_lock([&] { return state_between(held, at, chosen, found); });
    for (std::vector<double>* const rows : {&state.multipliers, &state.self_stress}) spread(rows, open);
    tensions = observe(system, tensions_of_groups(system), state);
    observed = observe(system, choose_observables(object, system), state);
  }
  spread(&found.multipliers, open);
  py::object result = keep(found, object, system, tensions);
  result.attr("__dict__")["positions"] = copy(at, 3);
  if (found.outcome.ok()) result.attr("__dict__")["state"] = std::move(state);
  result.attr("__dict__")["observables"] = observed;
  return result;
}

Buckling buckle(const py::object& object, const py::object& options, const py::object& positions,
                const py::object& open_rows, const py::object& solver, const py::kwargs& named) {
  const System system = read_system(object);
  const System held = without_open_constraints(system, flags_to_read(open_rows));
  const auto chosen = read_options<BucklingOptions>("find_buckling", options, solver, named, object);
  if (chosen.loads.empty())
    throw InputError("/buckling/loads", "none are named, wanted are those of the forces that grow, loads=\"weight\"");
  const std::vector<double> at = positions_of(system, positions);
  return without_lock([&] { return find_buckling(held, at, chosen); });
}

/// Returns shapes [modes, n, 3] as a view. Modes without damping have no imaginary shapes.
template <std::vector<double> Modes::*numbers>
py::array shapes_of(const py::object& self) {
  const auto& found = self.cast<const Modes&>();
  const auto count = (found.*numbers).empty() ? 0 : static_cast<py::ssize_t>(found.count());
  const py::ssize_t points = count > 0 ? static_cast<py::ssize_t>((found.*numbers).size()) / (3 * count) : 0;
  return py::array(view(found.*numbers, 0, self).attr("reshape")(count, points, 3));
}

template <std::vector<bool> EquilibriumResult::*member>
py::array_t<bool> flags_of(const EquilibriumResult& found) {
  const std::vector<bool>& given = found.*member;
  py::array_t<bool> flags(static_cast<py::ssize_t>(given.size()));
  std::copy(given.begin(), given.end(), flags.mutable_data());
  return flags;
}

void bind_records(py::module_& module) {
  using E = EquilibriumResult;
  Record<E>(module)
      .fields<&E::outcome>()
      .table_of_part<&E::stability>()
      .table_of_part<&E::search>()
      .points<&E::positions, &E::velocities>()
      .fields<&E::multipliers>()
      .points<&E::reactions, &E::support_forces>()
      .property("multipliers_unique", &flags_of<&E::multipliers_unique>, "numpy.ndarray")
      .fields<&E::self_stress, &E::self_stress_states, &E::dependences, &E::residual_force, &E::largest_force,
              &E::violation, &E::energy>()
      .property("open", &flags_of<&E::open>, "numpy.ndarray")
      .fields<&E::left_out>()
      .kept("observables", "list", "Observed of the scene, or those of a run; empty if no equilibrium was accepted")
      .kept("groups", "dict", groups_doc)
      .kept("tensions", "dict", tensions_doc)
      .kept("system", "System | Scene", "as it was given");
  using M = Modes;
  Record<M>(module)
      .fields<&M::outcome, &M::omega, &M::decay>()
      .property("shapes", &shapes_of<&M::shapes>, "numpy.ndarray")
      .property("shapes_imaginary", &shapes_of<&M::shapes_imaginary>, "numpy.ndarray")
      .fields<&M::residual_max, &M::degrees_of_freedom, &M::unstable_directions, &M::zero_modes, &M::rigid_zero_modes,
              &M::multipliers, &M::left_out>()
      .kept("positions", "numpy.ndarray", "float64 [n, 3], m, about which they swing")
      .kept("observables", "list", "Observed of the scene, or those of a run, at these positions; empty without modes")
      .kept("groups", "dict", groups_doc)
      .kept("tensions", "dict", tensions_doc)
      .kept("system", "System | Scene", "as it was given");
  Record<Buckling>(module).table();
}

}  // namespace

void bind_statics(py::module_& module) {
  using py::arg;
  const py::none none;
  bind_records(module);
  module.def("find_equilibrium", &rest, arg("system"), arg("options") = none, py::kw_only(), arg("solver") = none,
             R"doc(
Finds where a system rests, f + K lambda = 0, xi = 0, from its positions, which need not satisfy the constraints, and
whether it stays there. Velocities are not read.

system   a System or a Scene
options  EquilibriumOptions; None: those of the scene, or the defaults
solver   SolverOptions; likewise
Fields of both may stand by name: find_equilibrium(system, force_tolerance=1e-12).
Returns an EquilibriumResult: whether an equilibrium was found and accepted is in `ok`, else why not in `outcome.what`.
Raises InputError, naming the place, for wrong input, Coulomb friction and coordinates.)doc");
  module.def("modes", &vibrate, arg("system"), arg("positions") = none, arg("options") = none, py::kw_only(),
             arg("multipliers") = none, arg("open") = none, arg("solver") = none, R"doc(
The lowest small vibrations about an equilibrium, Z'WZ q = omega^2 Z'MZ q.

system       a System or a Scene
positions    float64 [n, 3], m, of the equilibrium; None: those of the system
options      ModesOptions; None: those of the scene, or the defaults
multipliers  float64 [num_equations], lambda of the equilibrium; None: the smallest of f + K lambda = 0
open         bool [num_equations], one-sided constraints that take no part (EquilibriumResult.open); None: no one
solver       SolverOptions; None: those of the scene, or the defaults
Fields of the options may stand by name: modes(system, rest.positions, count=4).
Returns Modes. Raises InputError where the positions are no equilibrium, naming the point with the largest force.)doc");
  module.def("find_buckling", &buckle, arg("system"), arg("options") = none, arg("positions") = none, py::kw_only(),
             arg("open") = none, arg("solver") = none, R"doc(
How often some loads may act until an equilibrium buckles, where they change the multipliers and not the shape.

system     a System or a Scene
options    BucklingOptions, which name the loads; None: those of the scene
positions  float64 [n, 3], m, of the equilibrium; None: those of the system
open       bool [num_equations], one-sided constraints that take no part; None: no one
solver     SolverOptions; None: those of the scene, or the defaults
Fields of the options may stand by name: find_buckling(system, loads="weight").
Returns a Buckling. Raises InputError where no load is named, and where the positions are no equilibrium.)doc");
}

}  // namespace tanor::python
