#include <tanor/dynamics.hpp>
#include <tanor/inverse_dynamics.hpp>

#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/handle.hpp"
#include "python/kinds.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

/// A Dynamics or an InverseDynamics with its description, from which it is made on first use.
template <class Library>
class Problem : public Handle<Library> {
 public:
  Problem(py::object the_system, py::object the_options)
      : Handle<Library>(py::type::of<Problem>().attr("__name__").template cast<std::string>()),
        system(std::move(the_system)),
        options(std::move(the_options)) {}

  const py::object system, options;

  /// Returns the system of the library's object, which was made.
  const System& description() const { return this->made().system(); }
  py::ssize_t num_points() {
    return this->run([](const Library& made) { return static_cast<py::ssize_t>(made.system().num_points()); });
  }

 private:
  Library make() override {
    System description = read_system(system);
    const auto solver = choose_options<SolverOptions>(options, system);
    return without_lock([&] { return Library(std::move(description), solver); });
  }
};
using DynamicsProblem = Problem<Dynamics>;
using InverseProblem = Problem<InverseDynamics>;

template <class Library>
std::unique_ptr<Problem<Library>> make_problem(const py::object& system, const py::object& options) {
  auto problem = std::make_unique<Problem<Library>>(system, options);
  problem->run([](Library&) {});  // reports errors now
  return problem;
}

/// Binds pickle and deepcopy, which keep the description.
template <class Library, class Class>
void bind_pickle(Class* type) {
  type->def(py::pickle([](const Problem<Library>& self) { return py::make_tuple(self.system, self.options); },
                       [](const py::tuple& state) { return std::make_unique<Problem<Library>>(state[0], state[1]); }));
}

/// The state of the arguments (positions, velocities, time) of a call.
class GivenState {
 public:
  GivenState(DynamicsProblem& self, const py::object& positions, const py::object& velocities, double time)
      : positions_(positions, {"positions", self.num_points()}),
        velocities_(velocities, {"velocities", self.num_points()}),
        time_(time) {}

  StateView view() const { return {.time = time_, .positions = positions_.span(), .velocities = velocities_.span()}; }

 private:
  PackedNumbers positions_, velocities_;
  double time_;
};

SolveReport solve(DynamicsProblem& self, const py::object& positions, const py::object& velocities, double time,
                  const py::object& accelerations, const py::object& multipliers, const py::object& reactions,
                  const py::object& support_forces, const py::object& active_forces,
                  const py::object& friction_forces) {
  const auto points = [&](const char* name, const py::object& array) {
    return numbers_to_write(array, {name, self.num_points()});
  };
  const auto num_rows = self.run([](const Dynamics& d) { return static_cast<py::ssize_t>(d.num_equations()); });
  const SolveArrays wanted{.accelerations = points("accelerations", accelerations),
                           .multipliers = numbers_to_write(multipliers, {"multipliers", num_rows, 0}),
                           .reactions = points("reactions", reactions),
                           .support_forces = points("support_forces", support_forces),
                           .active_forces = points("active_forces", active_forces),
                           .friction_forces = points("friction_forces", friction_forces)};
  const GivenState at(self, positions, velocities, time);
  return self.run([&](Dynamics& d) { return d.solve(at.view(), wanted); });
}

const System& system_of(const py::object& problem) {
  return problem.cast<const DynamicsProblem&>().description();
}

/// Returns a function of the arguments (positions, velocities, time) that calls a method of Dynamics at that state.
template <class Result>
auto at_state(Result (Dynamics::*call)(const StateView&)) {
  return [call](DynamicsProblem& self, const py::object& positions, const py::object& velocities, double time) {
    const GivenState at(self, positions, velocities, time);
    auto result = self.run([&](Dynamics& d) { return (d.*call)(at.view()); });
    if constexpr (std::is_same_v<Result, Solution>) {
      const py::object problem = py::cast(&self), solution = py::cast(std::move(result));
      const py::dict kept = solution.attr("__dict__");
      kept["system"] = self.system;
      kept["groups"] = py::cpp_function([problem](const py::object&) { return list_groups(system_of(problem)); });
      kept["tensions"] = py::cpp_function([problem](const Solution& at) {
        return tensions_from(observe(system_of(problem), tensions_of_groups(system_of(problem)), at));
      });
      return solution;
    } else {
      return result;
    }
  };
}

ProjectionReport project_positions(DynamicsProblem& self, const py::object& positions, double time) {
  const MutableState state{.time = time, .positions = numbers_to_write(positions, {"positions", self.num_points()})};
  return self.run([&](Dynamics& d) { return d.project_positions(state); });
}

ProjectionReport project_velocities(DynamicsProblem& self, const py::object& positions, const py::object& velocities,
                                    double time) {
  const PackedNumbers at(positions, {"positions", self.num_points()});
  const MutableVelocities state{.time = time,
                                .positions = at.span(),
                                .velocities = numbers_to_write(velocities, {"velocities", self.num_points()})};
  return self.run([&](Dynamics& d) { return d.project_velocities(state); });
}

StartReport start(DynamicsProblem& self, const py::object& positions, const py::object& velocities, double time,
                  const py::object& mode) {
  StartMode chosen = StartMode::Check;
  read({mode, "/mode"}, &chosen);
  const MutableState state{.time = time,
                           .positions = numbers_to_write(positions, {"positions", self.num_points()}),
                           .velocities = numbers_to_write(velocities, {"velocities", self.num_points()})};
  return self.run([&](Dynamics& d) { return d.start(state, chosen); });
}

MotionForces evaluate(InverseProblem& self, const py::object& positions, const py::object& velocities,
                      const py::object& accelerations, double time) {
  const auto n = self.num_points();
  const MotionState motion{PackedNumbers(positions, {"positions", n}).copy(),
                           PackedNumbers(velocities, {"velocities", n}).copy(),
                           PackedNumbers(accelerations, {"accelerations", n}).copy()};
  return self.run([&](InverseDynamics& d) { return d.evaluate(time, motion); });
}

py::tuple place(InverseProblem& self, const py::object& q, const py::object& q_dot, const py::object& q_ddot,
                double time) {
  const auto size = self.run([](const InverseDynamics& d) { return static_cast<py::ssize_t>(d.num_coordinates()); });
  const MotionState coordinates{PackedNumbers(q, {"q", size, 0}).copy(),
                                PackedNumbers(q_dot, {"q_dot", size, 0}).copy(),
                                PackedNumbers(q_ddot, {"q_ddot", size, 0}).copy()};
  const MotionState points = self.run([&](InverseDynamics& d) { return d.place(time, coordinates); });
  return py::make_tuple(copy(points.value, 3), copy(points.rate, 3), copy(points.acceleration, 3));
}

constexpr const char* dynamics_doc = R"doc(
Forward dynamics: accelerations and reactions of a system at one instant, for a time loop of your own.

Arrays are [n, 3] in the system's order. What is read may be anything of which numpy makes float64, what is written is
packed float64. Rows of multipliers stand in the order of `equation_names`. At supports positions and velocities are
replaced by the prescribed motion. A wrong type of numbers is a TypeError, a wrong shape a ValueError. Call again at the
state of the last call and nothing is solved anew.

The interpreter's lock is released inside; an object serves one thread at a time. pickle and copy.deepcopy keep the
description and make the solver anew where it is first used.

system   a System or a Scene
options  SolverOptions; None: those of the scene, or the defaults
Raises InputError, naming the place.
)doc";

constexpr const char* inverse_doc = R"doc(
Inverse dynamics: the forces that make a given motion.

system   a System or a Scene
options  SolverOptions; None: those of the scene, or the defaults
Raises InputError, naming the place.
)doc";

constexpr const char* state_doc = "positions, velocities  float64 [n, 3], m and m/s; velocities None: at rest\ntime  s";

void bind_dynamics_calls(py::class_<DynamicsProblem>* type) {
  using py::arg;
  const py::none none;
  const auto def = [&]<class Result>(const char* name, Result (Dynamics::*call)(const StateView&),
                                     const std::string& text) {
    type->def(name, at_state(call), arg("positions"), arg("velocities") = py::none(), arg("time") = 0.0,
              (text + "\n\n" + state_doc).c_str());
  };
  def("solution", &Dynamics::solution, "The state with accelerations, multipliers, reactions and loads, as a value.");
  def("split", &Dynamics::split,
      "The Euclidean split of accelerations, forces and friction into tangent and normal parts.");
  def("reactions_by_cause", &Dynamics::reactions_by_cause,
      "Multipliers and reactions by what causes them: each force, friction, inertia, drives.");
  def("friction_by_blocks", &Dynamics::friction_by_blocks,
      "Friction once more, by the three blocks of (43). Raises InputError where there is no friction.");
  def("certify", &Dynamics::certify,
      "Proves the answer at a state, which is found anew for it: identities, and second ways to the same numbers.");
  def("position_violation", &Dynamics::position_violation,
      "Largest relative violation of a constraint by positions, |xi|/|gradient|/length.");
  def("velocity_violation", &Dynamics::velocity_violation, "Largest relative violation of a constraint by velocities.");
  type->def(
      "rank",
      [](DynamicsProblem& self, const py::object& positions, const py::object& velocities, double time,
         bool thoroughly) {
        const GivenState at(self, positions, velocities, time);
        return self.run([&](Dynamics& d) { return d.rank(at.view(), thoroughly); });
      },
      arg("positions"), arg("velocities") = none, arg("time") = 0.0, arg("thoroughly") = false,
      "The rank of K: decided where there was a suspicion, or `thoroughly` in any case.");
  type->def("project_positions", &project_positions, arg("positions"), arg("time") = 0.0,
            "Nearest positions on the constraints in the norm of the masses; float64 [n, 3], written.");
  type->def("project_velocities", &project_velocities, arg("positions"), arg("velocities"), arg("time") = 0.0,
            "Nearest velocities that obey the constraints at positions; velocities, float64 [n, 3], are written.");
  type->def("start", &start, arg("positions"), arg("velocities"), arg("time") = 0.0, arg("mode") = "check",
            "Consistent start: corrects positions and velocities, float64 [n, 3], both written. mode \"check\" raises "
            "InputError where more than 1e-3 is to be corrected, \"project\" goes however far.");
}

}  // namespace

void bind_dynamics(py::module_& module) {
  using py::arg;
  const py::none none;
  py::class_<DynamicsProblem> dynamics(module, "Dynamics", dynamics_doc);
  dynamics.def(py::init(&make_problem<Dynamics>), arg("system"), arg("options") = none)
      .def("solve", &solve, arg("positions"), arg("velocities") = none, arg("time") = 0.0, py::kw_only(),
           arg("accelerations") = none, arg("multipliers") = none, arg("reactions") = none,
           arg("support_forces") = none, arg("active_forces") = none, arg("friction_forces") = none, R"doc(
Solves at a state and fills the arrays that are given.

positions, velocities  float64 [n, 3], m and m/s; velocities None: at rest
time                   s
accelerations          float64 [n, 3], written, m/s^2; at supports the prescribed one
multipliers            float64 [num_equations], written
reactions              float64 [n, 3], written, N: K lambda
support_forces         float64 [n, 3], written, N: the load that each support carries
active_forces          float64 [n, 3], written, N
friction_forces        float64 [n, 3], written, N)doc")
      .def_property_readonly(
          "system", [](const DynamicsProblem& self) { return self.system; }, "(System | Scene) as it was given")
      .def_property_readonly("num_points", &DynamicsProblem::num_points, "(int) supports included")
      .def_property_readonly("num_equations", &ask<DynamicsProblem, &Dynamics::num_equations>,
                             "(int) rows of the multipliers")
      .def_property_readonly("plan", &ask<DynamicsProblem, &Dynamics::plan>,
                             "(PlanSummary) how the equations are solved, and why so")
      .def_property_readonly("counters", &ask<DynamicsProblem, &Dynamics::counters>, "(Counters) work done so far");
  bind_dynamics_calls(&dynamics);
  bind_pickle<Dynamics>(&dynamics);

  py::class_<InverseProblem> inverse(module, "InverseDynamics", inverse_doc);
  inverse.def(py::init(&make_problem<InverseDynamics>), arg("system"), arg("options") = none)
      .def("evaluate", &evaluate, arg("positions"), arg("velocities"), arg("accelerations"), arg("time") = 0.0, R"doc(
The forces of a motion at one instant, and how far it is from the constraints.

positions, velocities, accelerations  float64 [n, 3], m, m/s, m/s^2
time                                  s)doc")
      .def("place", &place, arg("q"), arg("q_dot"), arg("q_ddot"), arg("time") = 0.0, R"doc(
(positions, velocities, accelerations), float64 [n, 3], of coordinates, float64 [num_coordinates]. Raises InputError
where there are none, or where some have charts of their own.)doc")
      .def_property_readonly(
          "system", [](const InverseProblem& self) { return self.system; }, "(System | Scene) as it was given")
      .def_property_readonly("num_points", &InverseProblem::num_points, "(int) supports included")
      .def_property_readonly("num_equations", &ask<InverseProblem, &InverseDynamics::num_equations>,
                             "(int) rows of the multipliers")
      .def_property_readonly("num_coordinates", &ask<InverseProblem, &InverseDynamics::num_coordinates>,
                             "(int) numbers that place all points");
  bind_pickle<InverseDynamics>(&inverse);
}

}  // namespace tanor::python
