#include <tanor/constrainer.hpp>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/handle.hpp"
#include "python/kinds.hpp"

namespace tanor::python {
namespace {

/// float [3, 3], edges a, b, c row by row, or float [3] for an orthogonal cell.
PeriodicCell read_cell(const py::object& cell, const py::object& repeats) {
  PeriodicCell result;
  const Given given{cell, "/cell"};
  std::vector<Vector3> edges;
  if (py::len(cell) == 3 && PySequence_Check(py::object(cell[py::int_(0)]).ptr()) == 0) {
    Vector3 lengths;
    read(given, &lengths);
    for (std::size_t k = 0; k < 3; ++k) result.edges[k][k] = lengths[k];
  } else {
    read(given, &edges);
    if (edges.size() != 3) given.fail("three edges [3, 3], or three lengths of an orthogonal cell");
    std::copy(edges.begin(), edges.end(), result.edges.begin());
  }
  const std::vector<Given> each = Given{repeats, "/repeats"}.entries("three of True and False");
  if (each.size() != 3) Given{repeats, "/repeats"}.fail("three of True and False");
  for (std::size_t k = 0; k < 3; ++k) result.repeats[k] = each[k].value.cast<bool>();
  return result;
}

/// A Constrainer with its description.
class HostHandle : public Handle<Constrainer> {
 public:
  /// What the user gave; None where nothing was given. `present_cell` is that of the last set_cell.
  struct Description {
    py::object masses, constraints, positions, cell, repeats, images, options, present_cell;
  };

  explicit HostHandle(Description description) : Handle("Constrainer"), description_(std::move(description)) {}

  const Description& description() const { return description_; }

  void set_cell(const py::object& edges, const py::object& repeats) {
    const py::object kept = repeats.is_none() ? description_.repeats : repeats;
    const PeriodicCell cell = read_cell(edges, kept);
    run([&](Constrainer& constrainer) { constrainer.set_cell(cell); });
    description_.present_cell = py::make_tuple(py::module_::import("numpy").attr("array")(edges), kept);
  }

  py::ssize_t num_points() const { return py::len(description_.masses); }
  py::ssize_t num_rows() {
    return run([](const Constrainer& c) { return static_cast<py::ssize_t>(c.num_rows()); });
  }

 private:
  Constrainer make() override {
    std::vector<double> masses;
    read({description_.masses, "/masses"}, &masses);
    std::vector<Constraint> constraints = read_constraints(description_.constraints);
    const SolverOptions options = read_solver_options(description_.options);
    const ConstPointArray at = points_to_read(description_.positions, {"positions", num_points()});
    const bool has_cell = !description_.cell.is_none();
    const Periodicity periodicity = has_cell ? read_periodicity() : Periodicity{};
    Constrainer made = without_lock([&] {
      return has_cell ? Constrainer(masses, std::move(constraints), at, periodicity, options)
                      : Constrainer(masses, std::move(constraints), at, options);
    });
    if (!description_.present_cell.is_none()) {
      const auto [edges, repeats] = description_.present_cell.cast<std::pair<py::object, py::object>>();
      made.set_cell(read_cell(edges, repeats));
    }
    return made;
  }

  Periodicity read_periodicity() const {
    Periodicity result{.cell = read_cell(description_.cell, description_.repeats)};
    if (description_.images.is_none()) return result;
    for (const Given& row : Given{description_.images, "/images"}.entries("three whole numbers a row")) {
      const std::vector<Given> numbers = row.entries("three whole numbers");
      if (numbers.size() != 3) row.fail("three whole numbers");
      std::array<int, 3>& image = result.images.emplace_back();
      for (std::size_t k = 0; k < 3; ++k) read(numbers[k], &image[k]);
    }
    return result;
  }

  Description description_;
};

/// The arrays of a call: as many rows as points, or, with an index, those that it names.
class CallArrays {
 public:
  CallArrays(HostHandle& handle, const py::object& index)
      : handle_(handle), index_(index_to_read(index, {"index", handle.num_points(), 0})) {}

  ConstPointArray in(const char* name, const py::object& array) const {
    return points_to_read(array, {name, rows()}, index_);
  }
  PointArray out(const char* name, const py::object& array) const {
    return points_to_write(array, {name, rows()}, index_);
  }
  ConstraintForces wanted(const py::object& multipliers, const py::object& forces, const py::object& stress) const {
    ConstraintForces result;
    if (!multipliers.is_none())
      result.multipliers = numbers_to_write(multipliers, {"multipliers", handle_.num_rows(), 0});
    result.forces = out("constraint_forces", forces);
    result.stress = points_to_write(stress, {"stress", rows(), 9}, index_);
    return result;
  }

 private:
  std::optional<py::ssize_t> rows() const {
    return index_.empty() ? std::optional(handle_.num_points()) : std::nullopt;
  }

  HostHandle& handle_;
  std::span<const Index> index_;
};

ConstraintReport constrain_positions(HostHandle& handle, double step, const py::object& old_positions,
                                     const py::object& positions, const py::object& velocities,
                                     const py::object& multipliers, const py::object& constraint_forces,
                                     const py::object& stress, const py::object& old_cell, const py::object& index,
                                     double time, bool measures) {
  const CallArrays arrays(handle, index);
  PositionStep call{.step = step,
                    .old_positions = arrays.in("old_positions", old_positions),
                    .positions = arrays.out("positions", positions),
                    .velocities = arrays.out("velocities", velocities),
                    .wanted = arrays.wanted(multipliers, constraint_forces, stress),
                    .time = time,
                    .measures = measures};
  if (call.old_positions.data == call.positions.data)
    throw py::value_error("old_positions: it is the same array as positions; keep positions.copy() before they move");
  std::optional<PeriodicCell> cell;
  if (!old_cell.is_none()) {
    cell = read_cell(old_cell, handle.description().repeats);
    call.old_cell = &*cell;
  }
  return handle.run([&](Constrainer& c) { return c.constrain_positions(call); });
}

ConstraintReport constrain_velocities(HostHandle& handle, double step, const py::object& positions,
                                      const py::object& velocities, const py::object& multipliers,
                                      const py::object& constraint_forces, const py::object& stress,
                                      const py::object& index, double time, bool measures) {
  const CallArrays arrays(handle, index);
  const VelocityStep call{.step = step,
                          .positions = arrays.in("positions", positions),
                          .velocities = arrays.out("velocities", velocities),
                          .wanted = arrays.wanted(multipliers, constraint_forces, stress),
                          .time = time,
                          .measures = measures};
  return handle.run([&](Constrainer& c) { return c.constrain_velocities(call); });
}

ConstraintReport solve(HostHandle& handle, const py::object& positions, const py::object& velocities,
                       const py::object& forces, const py::object& accelerations, const py::object& multipliers,
                       const py::object& constraint_forces, const py::object& stress, const py::object& index,
                       double time, bool measures) {
  const CallArrays arrays(handle, index);
  const HostState call{.positions = arrays.in("positions", positions),
                       .velocities = arrays.in("velocities", velocities),
                       .forces = arrays.in("forces", forces),
                       .accelerations = arrays.out("accelerations", accelerations),
                       .wanted = arrays.wanted(multipliers, constraint_forces, stress),
                       .time = time,
                       .measures = measures};
  return handle.run([&](Constrainer& c) { return c.solve(call); });
}

ConstraintReport project_forces(HostHandle& handle, const py::object& positions, const py::object& forces,
                                const py::object& index, double time) {
  const CallArrays arrays(handle, index);
  const ConstPointArray at = arrays.in("positions", positions);
  const PointArray projected = arrays.out("forces", forces);
  return handle.run([&](Constrainer& c) { return c.project_forces(at, projected, time); });
}

ConstraintReport project_positions(HostHandle& handle, const py::object& positions, const py::object& index,
                                   double time) {
  const PointArray projected = CallArrays(handle, index).out("positions", positions);
  return handle.run([&](Constrainer& c) { return c.project_positions(projected, time); });
}

LogDeterminant log_det(HostHandle& handle, const py::object& positions, const py::object& gradient,
                       const py::object& index, double time) {
  const CallArrays arrays(handle, index);
  const ConstPointArray at = arrays.in("positions", positions);
  const PointArray derivative = arrays.out("gradient", gradient);
  return handle.run([&](Constrainer& c) { return c.log_det(at, derivative, time); });
}

ConstraintReport violation(HostHandle& handle, const py::object& positions, const py::object& index, double time) {
  const ConstPointArray at = CallArrays(handle, index).in("positions", positions);
  return handle.run([&](Constrainer& c) { return c.violation(at, time); });
}

RankReport rank(HostHandle& handle, const py::object& positions, const py::object& index, double time) {
  const ConstPointArray at = CallArrays(handle, index).in("positions", positions);
  return handle.run([&](Constrainer& c) { return c.rank(at, time); });
}

std::unique_ptr<HostHandle> make_handle(const py::object& masses, const py::object& constraints,
                                        const py::object& positions, const py::object& cell, const py::object& repeats,
                                        const py::object& images, const py::object& options) {
  const auto copy_array = py::module_::import("numpy").attr("array");
  (void)points_to_read(positions, {"positions", py::len(masses)});
  if (cell.is_none() && !images.is_none()) throw py::value_error("images: they need a cell");
  auto handle = std::make_unique<HostHandle>(HostHandle::Description{copy_array(masses, "float64"),
                                                                     py::list(constraints), copy_array(positions), cell,
                                                                     repeats, images, options, py::none()});
  handle->run([](const Constrainer&) {});  // complains now
  return handle;
}

py::tuple get_state(const HostHandle& handle) {
  const HostHandle::Description& d = handle.description();
  return py::make_tuple(d.masses, d.constraints, d.positions, d.cell, d.repeats, d.images, d.options, d.present_cell);
}

std::unique_ptr<HostHandle> set_state(const py::tuple& s) {
  return std::make_unique<HostHandle>(HostHandle::Description{s[0], s[1], s[2], s[3], s[4], s[5], s[6], s[7]});
}

constexpr const char* class_doc = R"doc(
Exact constraints for a simulation that owns its arrays, its forces and its time loop: SHAKE and RATTLE for any graph of
any constraints, solved to rounding. A step of velocity Verlet is

    v += h/2*f/m;  old = r.copy();  r += h*v
    c.constrain_positions(h, old, r, v)
    f = forces(r);  v += h/2*f/m
    c.constrain_velocities(h, r, v)

Arrays of points are float64 [n, 3], read and written in place, never copied; rows may be any distance apart (views of
wider arrays). After a failure (`report.ok` is False) no array was touched. A wrong type of numbers is a TypeError, a
wrong shape or a read-only array a ValueError. Units are the host's own.

The interpreter's lock is released inside; a handle serves one thread at a time. pickle and copy.deepcopy keep the
description and make the handle anew where it is first used.

masses       float [n]; inf: a support, which constraints never move
constraints  a list of Rods, Planes, ...
positions    float64 [n, 3]: lengths that are not given are those found here
cell         float [3, 3], the edges of a periodic cell row by row, or [3] for an orthogonal one; None: no cell
repeats      along which of the edges the cell repeats itself
images       int [rows, 3]: which image each rod joins, for positions that are never wrapped; None: the nearest ones
options      SolverOptions
Raises InputError, naming the place.
)doc";

}  // namespace

void bind_constrainer(py::module_& module) {
  using py::arg;
  const py::none none;
  py::class_<HostHandle>(module, "Constrainer", class_doc)
      .def(py::init(&make_handle), arg("masses"), arg("constraints"), arg("positions"), py::kw_only(),
           arg("cell") = none, arg("repeats") = py::make_tuple(true, true, true), arg("images") = none,
           arg("options") = none)
      .def("constrain_positions", &constrain_positions, arg("step"), arg("old_positions"), arg("positions"),
           arg("velocities") = none, py::kw_only(), arg("multipliers") = none, arg("constraint_forces") = none,
           arg("stress") = none, arg("old_cell") = none, arg("index") = none, arg("time") = 0.0, arg("measures") = true,
           R"doc(
SHAKE: positions += M^-1 K(old) mu, so that they obey the constraints, velocities += M^-1 K(old) mu/step.

step               h, not 0; negative: backwards
old_positions      float64 [n, 3], which obey the constraints
positions          float64 [n, 3], written
velocities         float64 [n, 3] at half of the step, written; may be absent
multipliers        float64 [num_rows], written: 2 mu/h^2; the tension of a rod is minus that
constraint_forces  float64 [n, 3], written: K lambda, what the constraints do to each point
stress             float64 [n, 9], written: r (x) F of each constraint, shared among its points
old_cell           the cell of old_positions where it is another one
index              int32 [n]: the row of each point in the arrays, where they have another order or more rows
time               at the end of the step, for lengths that depend on it
measures           finds virial, largest turn, work and worst row; False saves that)doc")
      .def("constrain_velocities", &constrain_velocities, arg("step"), arg("positions"), arg("velocities"),
           py::kw_only(), arg("multipliers") = none, arg("constraint_forces") = none, arg("stress") = none,
           arg("index") = none, arg("time") = 0.0, arg("measures") = true, R"doc(
RATTLE's second half: velocities += M^-1 K(r) nu, so that they obey the constraints at positions.

step        h: multipliers are 2 nu/h; 0: they are the impulses nu
positions   float64 [n, 3]
velocities  float64 [n, 3], written
The others as in constrain_positions.)doc")
      .def("solve", &solve, arg("positions"), arg("velocities"), arg("forces"), py::kw_only(),
           arg("accelerations") = none, arg("multipliers") = none, arg("constraint_forces") = none,
           arg("stress") = none, arg("index") = none, arg("time") = 0.0, arg("measures") = true, R"doc(
Accelerations and multipliers of this instant, S lambda = -(phi + K'M^-1 f). The virial is exact.

positions, velocities, forces  float64 [n, 3]
accelerations                  float64 [n, 3], written: M^-1 (f + K lambda), 0 at supports
The others as in constrain_positions.)doc")
      .def("project_forces", &project_forces, arg("positions"), arg("forces"), py::kw_only(), arg("index") = none,
           arg("time") = 0.0,
           "forces -= K S^-1 K'M^-1 forces, float64 [n, 3], written: what is left moves no constraint. For minimisers.")
      .def("project_positions", &project_positions, arg("positions"), py::kw_only(), arg("index") = none,
           arg("time") = 0.0,
           "The nearest positions on the constraints, in the norm of the masses, from anywhere; float64 [n, 3], "
           "written. For starts, before the first forces.")
      .def(
          "log_det", &log_det, arg("positions"), arg("gradient") = none, py::kw_only(), arg("index") = none,
          arg("time") = 0.0,
          "ln det S at positions; gradient, float64 [n, 3], is written: its derivative (rods alone have one). Fixman's "
          "metric force is -kT/2 times that.")
      .def("violation", &violation, arg("positions"), py::kw_only(), arg("index") = none, arg("time") = 0.0,
           "Largest |xi|/|gradient|/length at positions, float64 [n, 3], with its row.")
      .def("rank", &rank, arg("positions"), py::kw_only(), arg("index") = none, arg("time") = 0.0,
           "How many degrees of freedom the constraints take at positions, float64 [n, 3], also where rows depend on "
           "others.")
      .def("set_cell", &HostHandle::set_cell, arg("cell"), arg("repeats") = none,
           "The periodic cell from the next call on, as in the constructor; repeats None: as before.")
      .def(
          "row_name",
          [](HostHandle& handle, std::size_t row) {
            return handle.run([&](const Constrainer& c) { return c.row_name(row); });
          },
          arg("row"), "\"rods[17]\", in the order in which the constraints were given.")
      .def_property_readonly("num_points", &HostHandle::num_points, "(int) number of points, supports included")
      .def_property_readonly("num_rows", &HostHandle::num_rows, "(int) number of equations")
      .def_property_readonly(
          "plan", [](HostHandle& handle) { return handle.run([](const Constrainer& c) { return c.plan(); }); },
          "(PlanSummary) how the equations are solved, and why so")
      .def_property_readonly(
          "counters", [](HostHandle& handle) { return handle.run([](const Constrainer& c) { return c.counters(); }); },
          "(Counters) work done so far by this handle")
      .def("__repr__",
           [](HostHandle& handle) {
             return "Constrainer(num_points=" + std::to_string(handle.num_points()) +
                    ", num_rows=" + std::to_string(handle.num_rows()) + ")";
           })
      .def(py::pickle(&get_state, &set_state));
}

}  // namespace tanor::python
