#include <tanor/motion.hpp>

#include <chrono>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/functions.hpp"
#include "python/handle.hpp"
#include "python/kinds.hpp"
#include "python/records.hpp"

namespace tanor::python {
namespace {

using Clock = std::chrono::steady_clock;

/// Checks after each step if Python wants the run to end: signals (Ctrl-C) every 50 ms, the user's callback after each
/// step. What the callback raises is kept until the library has returned.
class Watch {
 public:
  explicit Watch(const py::object& progress) : progress_(progress) {}

  bool goes_on(const MotionReport& report) {
    const Clock::time_point now = Clock::now();
    if (progress_.is_none() && now < next_look_) return true;
    const py::gil_scoped_acquire acquired;
    try {
      if (now >= next_look_) {
        next_look_ = now + std::chrono::milliseconds(50);
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      }
      if (progress_.is_none()) return true;
      const py::object answer = progress_(report);
      return answer.is_none() || answer.cast<bool>();
    } catch (...) {
      raised_ = std::current_exception();
      return false;
    }
  }

  void raise_what_was_kept() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  const py::object& progress_;
  Clock::time_point next_look_ = Clock::now() + std::chrono::milliseconds(50);
  std::exception_ptr raised_;
};

/// A Simulation with the description from which it was made.
class Run : public Handle<Simulation> {
 public:
  Run(py::object the_system, py::object motion, py::object solver, std::optional<double> t_start)
      : Handle("Simulation"),
        system(std::move(the_system)),
        motion_(std::move(motion)),
        solver_(std::move(solver)),
        t_start_(t_start.value_or(start_of_scene(system))) {
    run([](const Simulation&) {});  // reports errors now
  }

  const py::object system;

  const Simulation& now() const { return made(); }
  std::size_t add_observable(const Observable& what) {
    const std::size_t number = run([&](Simulation& s) { return s.add_observable(what); });
    observables_.push_back(what);
    return number;
  }
  /// Returns what pickle and deepcopy keep: the description, the observables and the bytes of `save`.
  py::tuple state() {
    py::list observed;
    for (const Observable& each : observables_)
      observed.append(py::make_tuple(each.text, each.name, each.every_step, each.unit));
    return py::make_tuple(system, motion_, solver_, t_start_, to_bytes(ask<Run, &Simulation::save>(*this)), observed);
  }
  static std::unique_ptr<Run> from_state(const py::tuple& state) {
    auto result = std::make_unique<Run>(state[0], state[1], state[2], state[3].cast<double>());
    for (const py::handle each : state[5]) {
      const auto [text, name, every_step, unit] =
          each.cast<std::tuple<std::string, std::string, bool, std::string>>();
      result->add_observable({.name = name, .text = text, .every_step = every_step, .unit = unit});
    }
    result->restore(state[4]);
    return result;
  }
  void restore(const py::bytes& saved) {
    run([&](Simulation& s) { s.restore(bytes_of(saved)); });
  }

  Outcome advance_to(double t_end, const py::object& progress) {
    Watch watch(progress);
    Outcome outcome = run([&](Simulation& s) {
      return s.advance_to(t_end, [&](const MotionReport& report) { return watch.goes_on(report); });
    });
    watch.raise_what_was_kept();
    return outcome;
  }

 private:
  Simulation make() override {
    System description = read_system(system);
    const auto motion = choose_options<MotionOptions>(motion_, system);
    const auto solver = choose_options<SolverOptions>(solver_, system);
    Simulation made = without_lock([&] { return Simulation(std::move(description), motion, solver, t_start_); });
    add_requests_of_scene(system, &made);
    return made;
  }

  py::object motion_, solver_;
  double t_start_;
  std::vector<Observable> observables_;
};

/// Returns what a method tells of the state that the last call left.
template <auto method>
auto present(const Run& self) {
  return (self.now().*method)();
}

std::size_t add_observable(Run& self, const std::string& what, const std::string& name, bool every_step,
                           const std::string& unit) {
  return self.add_observable({.name = name, .text = what, .every_step = every_step, .unit = unit});
}

std::vector<Observed> observe(Run& self) {
  return self.run([](Simulation& s) { return list_of(s.observe()); });
}

std::vector<Observed> tensions_now(Run& self) {
  return self.run([](Simulation& s) { return s.observe(tensions_of_groups(s.system())); });
}

std::size_t add_event(Run& self, const py::object& function, const py::object& direction, bool stops,
                      const std::string& name, const std::string& when, const py::object& action,
                      const std::string& of) {
  if (function.is_none() && when.empty())
    throw py::type_error("add_event: wanted a function of (t, positions, velocities), or when=\"any tension(links) > 20\"");
  const bool is_condition = py::isinstance<py::str>(function) && when.empty();
  if (!is_condition && !function.is_none() && PyCallable_Check(function.ptr()) == 0)
    throw py::type_error("function: found " + py::repr(function).cast<std::string>() +
                         ", wanted a function of (t, positions, velocities), or a condition alone");
  Event event{.name = name, .stops = stops, .when = is_condition ? function.cast<std::string>() : when, .of = of};
  read({direction, "/direction"}, &event.direction);
  read({action, "/do"}, &event.action);
  if (!function.is_none() && !is_condition)
    event.value = [f = Shared(function)](double t, std::span<const double> r, std::span<const double> v) {
      const py::gil_scoped_acquire acquired;
      return (*f)(t, view(r, 3, py::none()), view(v, 3, py::none())).cast<double>();
    };
  return self.run([&](Simulation& s) { return s.add_event(event); });
}

py::bytes save(Run& self) {
  return to_bytes(ask<Run, &Simulation::save>(self));
}

constexpr const char* simulation_doc = R"doc(
A system on its way through time. The start is made consistent; a numerical failure is in `outcome`.

The arrays positions, velocities, ... are views of the state that the start, the last advance_to or restore ended with:
float64, read-only, and they show the next state after the next call; copy what is to stay.

The interpreter's lock is released while it steps; an object serves one thread at a time. pickle and copy.deepcopy keep
what was given and the present state, no events and no passages: copy and original go on with the same bits.

system   a System or a Scene
motion   MotionOptions; None: those of the scene, or the defaults
solver   SolverOptions; likewise
options  fields of MotionOptions and SolverOptions by name: Simulation(system, rtol=1e-10)
t_start  s; None: that of the scene, or 0
Raises InputError, naming the place.
)doc";

void bind_arrays(py::class_<Run>* type) {
  const auto array = [&](const char* name, std::span<const double> (Simulation::*get)() const, py::ssize_t columns,
                         const char* text) {
    type->def_property_readonly(
        name, [=](const py::object& self) { return view((self.cast<const Run&>().now().*get)(), columns, self); },
        text);
  };
  array("positions", &Simulation::positions, 3, "(numpy.ndarray) float64 [n, 3], m");
  array("velocities", &Simulation::velocities, 3, "(numpy.ndarray) float64 [n, 3], m/s");
  array("accelerations", &Simulation::accelerations, 3, "(numpy.ndarray) float64 [n, 3], m/s^2");
  array("reactions", &Simulation::reactions, 3, "(numpy.ndarray) float64 [n, 3], N: K lambda");
  array("support_forces", &Simulation::support_forces, 3,
        "(numpy.ndarray) float64 [n, 3], N: the load that each support carries");
  array("multipliers", &Simulation::multipliers, 0, "(numpy.ndarray) float64 [num_equations]");
  array("coordinates", &Simulation::coordinates, 0, "(numpy.ndarray) float64, q; none in normal form");
  array("coordinate_rates", &Simulation::coordinate_rates, 0, "(numpy.ndarray) float64, q_dot");
}

}  // namespace

void bind_simulation(py::module_& module) {
  using py::arg;
  const py::none none;
  py::class_<Run> type(module, "Simulation", simulation_doc);
  type.def(py::init([](const py::object& system, py::object motion, py::object solver, std::optional<double> t_start,
                       const py::kwargs& options) {
             take_named_options<MotionOptions>("Simulation", system, options, &motion, &solver);
             return std::make_unique<Run>(system, motion, solver, t_start);
           }),
           arg("system"), arg("motion") = none, arg("solver") = none, arg("t_start") = none)
      .def(py::pickle([](Run& self) { return self.state(); }, &Run::from_state))
      .def("advance_to", &Run::advance_to, arg("t_end"), arg("progress") = none, R"doc(
Steps to exactly t_end, s, or to an event that stops; after a failure the state is that of the last good step.

progress  called with a MotionReport after every step; False ends the run there
Ctrl-C, and what progress raises, end the run after a step, too, and are raised then: the simulation can go on.)doc")
      .def("add_observable", &add_observable, arg("what"), py::kw_only(), arg("name") = "", arg("every_step") = false,
           arg("unit") = "", R"doc(
Observes "max tension(links)", "moment(crank, z)", "load(hook).z" and the like (docs/observables.md); returns the
observable's number, of one that is there already its own.

name        in results; `what` if it is empty
every_step  extremes of all steps; otherwise of the instants at which `observe` is called
unit        letters of a formula, "kg"; a quantity alone has those of the system)doc")
      .def("observe", &observe, R"doc(
list[Observed]: all observables at the present state, also inside a progress callback.)doc")
      .def("add_event", &add_event, arg("function") = none, py::kw_only(), arg("direction") = "both",
           arg("stops") = false, arg("name") = "", arg("when") = "", arg("do") = "report", arg("of") = "", R"doc(
From now on looks for the zeros of function(t, positions, velocities) -> float, or for the instants at which a condition
becomes true; returns the event's number.

direction  "both", "rising", "falling"
stops      ends the advance there
when       a condition, "any tension(links) > 20", "t > 2" (docs/observables.md); may stand in place of the function
do         "report", "stop", "break" (a rod, rope, spring or bond is taken out), "release" (a support or guide lets go)
of         what is taken out; "": the member of which the condition speaks)doc")
      .def("_observe",
           [](Run& self, const std::string& text) {
             const Observable wanted{.text = text};
             return self.run([&](Simulation& s) { return s.observe(std::span(&wanted, 1)); });
           })
      .def_property_readonly(
          "tensions", [](Run& self) { return tensions_from(tensions_now(self)); },
          (std::string("(dict[str, numpy.ndarray]) ") + tensions_doc).c_str())
      .def_property_readonly(
          "groups", [](const Run& self) { return list_groups(self.now().system()); },
          (std::string("(dict[str, tuple]) ") + groups_doc).c_str())
      .def_property_readonly(
          "units", [](const Run& self) { return letters_of(self.now().system().units); },
          "(dict[str, str]) letters of length, mass, time, force, energy, temperature and pressure; empty if not known")
      .def_property_readonly(
          "passages", [](Run& self) { return list_of(self.now().passages()); },
          "(list[Passage]) of events, in the order of time")
      .def(
          "solution",
          [](Run& self) {
            const std::vector<Observed> tensions = tensions_now(self);
            return keep(ask<Run, &Simulation::solution>(self), self.system, self.now().system(), tensions);
          },
          "The present state as a value, also inside a progress callback.")
      .def(
          "friction_forces",
          [](Run& self) { return copy(self.run([](Simulation& s) { return s.friction_forces(); }), 3); },
          "float64 [n, 3], N: what friction does to each point at the present state, also inside a progress callback.")
      .def("certify", &ask<Run, &Simulation::certify>,
           "Proves the answer at the present state, also inside a progress callback.")
      .def("rank", &ask<Run, &Simulation::rank>, "The rank of K at the present state.")
      .def("save", &save, "The present state as bytes, for restore of a simulation of an equal system.")
      .def("restore", &Run::restore, arg("saved"),
           "Goes on from saved bytes. Raises InputError for bytes that are damaged or of another system.")
      .def_readonly("system", &Run::system, "(System | Scene) as it was given")
      .def_property_readonly("plan", &present<&Simulation::plan>,
                             "(PlanSummary) how the equations are solved, and why so")
      .def_property_readonly("outcome", &present<&Simulation::outcome>,
                             "(Outcome) of the start, the last advance_to or restore")
      .def_property_readonly("report", &present<&Simulation::report>, "(MotionReport) of the motion so far")
      .def_property_readonly("time", &present<&Simulation::time>, "(float) s");
  bind_arrays(&type);
}

}  // namespace tanor::python
