#include <tanor/constrainer.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/arrays.hpp"
#include "python/bindings.hpp"
#include "python/host_handle.hpp"
#include "python/values.hpp"

namespace tanor::python {
namespace {

/// The arrays of a call, with as many rows as points or, with an index, as it names.
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
                                     double time, bool measures, double tolerance) {
  const CallArrays arrays(handle, index);
  PositionStep call{.step = step,
                    .old_positions = arrays.in("old_positions", old_positions),
                    .positions = arrays.out("positions", positions),
                    .velocities = arrays.out("velocities", velocities),
                    .wanted = arrays.wanted(multipliers, constraint_forces, stress),
                    .time = time,
                    .measures = measures,
                    .tolerance = tolerance};
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

/// Calls Constrainer::solve or Constrainer::observe.
template <auto solve>
ConstraintReport solve_host(HostHandle& handle, const py::object& positions, const py::object& velocities,
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
  return handle.run([&](Constrainer& c) { return (c.*solve)(call); });
}

ConstraintReport project_forces(HostHandle& handle, const py::object& positions, const py::object& forces,
                                const py::object& multipliers, const py::object& constraint_forces,
                                const py::object& stress, const py::object& index, double time) {
  const CallArrays arrays(handle, index);
  const ConstPointArray at = arrays.in("positions", positions);
  const PointArray projected = arrays.out("forces", forces);
  const ConstraintForces wanted = arrays.wanted(multipliers, constraint_forces, stress);
  return handle.run([&](Constrainer& c) { return c.project_forces(at, projected, time, wanted); });
}

ConstraintReport project_host_positions(HostHandle& handle, const py::object& positions, const py::object& index,
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

std::unique_ptr<HostHandle> make_handle(py::object masses, const py::object& constraints, const py::object& positions,
                                        const py::object& cell, const py::object& repeats, const py::object& images,
                                        const py::object& options) {
  const auto copy_array = py::module_::import("numpy").attr("array");
  if (py::module_::import("numpy").attr("ndim")(masses).equal(py::int_(0)))
    masses = py::module_::import("numpy").attr("full")(py::len(positions), masses);
  (void)points_to_read(positions, {"positions", py::len(masses)});
  (void)Given{constraints, "/constraints"}.entries("a list of constraints");
  if (cell.is_none() && !images.is_none()) throw py::value_error("images: they need a cell");
  auto handle = std::make_unique<HostHandle>(HostHandle::Description{copy_array(masses, "float64"),
                                                                     py::list(constraints), copy_array(positions), cell,
                                                                     repeats, images, options, py::none()});
  handle->run([](const Constrainer&) {});  // reports errors now
  return handle;
}

ConstraintId add(HostHandle& handle, const py::object& constraint, const py::object& positions,
                 const py::object& images, const py::object& index) {
  return handle.add(constraint, CallArrays(handle, index).in("positions", positions), images);
}

double removed_degrees_of_freedom(HostHandle& handle, const py::object& positions, const py::object& flags,
                                  const py::object& index, double time) {
  const ConstPointArray at = CallArrays(handle, index).in("positions", positions);
  const auto array = py::array_t<bool, py::array::c_style | py::array::forcecast>::ensure(flags);
  PyErr_Clear();
  if (!array || array.ndim() != 1) throw py::value_error("flags: wanted True or False for each point, [n]");
  const std::vector<std::uint8_t> each(array.data(), array.data() + array.size());
  return handle.run([&](Constrainer& c) { return c.removed_degrees_of_freedom(at, each, time); });
}

py::slice rows(HostHandle& handle, ConstraintId id) {
  const RowRange range = handle.run([&](const Constrainer& c) { return c.rows(id); });
  return {static_cast<py::ssize_t>(range.first), static_cast<py::ssize_t>(range.first + range.count), 1};
}

constexpr const char* constrainer_doc = R"doc(
Exact constraints for a simulation that owns its arrays, its forces and its time loop: SHAKE and RATTLE for any graph of
any constraints, solved to rounding. A step of velocity Verlet is

    v += h/2*f/m;  old = r.copy();  r += h*v
    c.constrain_positions(h, old, r, v)
    f = forces(r);  v += h/2*f/m
    c.constrain_velocities(h, r, v)

Arrays of points are float64 [n, 3], read and written in place, never copied; rows may be any distance apart (views of
wider arrays). After a failure (`report.ok` is False) no array was touched. A wrong type of numbers is a TypeError, a
wrong shape or a read-only array a ValueError. Units are the host's own.

What is constrained may change between calls (add, remove, set_lengths, set_masses, renumber): the next call plans what
an edit has touched, and nothing else. Constraints have ids, which ascend in the order in which they came, from 0 on.
Wrong input is an InputError, after which nothing has changed.

The interpreter's lock is released inside; a handle serves one thread at a time. pickle and copy.deepcopy keep what was
given, all edits and the bytes of save: copy and original go on with the same bits, and ids are the same.

masses       float [n], or one number for all; inf: a support, which constraints never move
constraints  a list of Rods, Planes, ...
positions    float64 [n, 3]: lengths that are not given are those found here
cell         float [3, 3], the edges of a periodic cell row by row, or [3] for an orthogonal one; None: no cell
repeats      along which of the edges the cell repeats itself
images       int [rows, 3]: which image each rod joins, for positions that are never wrapped; None: the nearest ones
options      SolverOptions
Raises InputError, naming the place.
)doc";

/// Binds edits, and what is remembered.
void bind_edits(py::class_<HostHandle>* type) {
  using py::arg;
  const py::none none;
  type->def("add", &add, arg("constraint"), arg("positions") = none, py::kw_only(), arg("images") = none,
            arg("index") = none, R"doc(
A group like those of the constructor. Returns the id of its first member; the others follow.

constraint  Rods, Planes, ...
positions   float64 [n, 3], where the points are now: lengths that are not given are those found here; else it may be
            absent
images      int [rows, 3], if the constructor had them: which image each rod joins
index       as in constrain_positions)doc")
      .def("remove", &HostHandle::remove, arg("ids"), "Takes away the constraints with these ids, int [k].")
      .def("set_lengths", &HostHandle::set_lengths, arg("ids"), arg("lengths"), arg("rates") = none, R"doc(
Lengths of rods (radii, offsets, cosines, values) at the time of the calls from now on.

ids      int [k]
lengths  float [k]
rates    float [k]: how fast they change; None: they are at rest. Where a step begins they are shorter by step times
         the rate. Where a rate was given once nothing is planned any more.)doc")
      .def("set_masses", &HostHandle::set_masses, arg("points"), arg("masses"), R"doc(
Masses from now on; what is infinite remains so, and what is not.

points  int [k]
masses  float [k])doc")
      .def("renumber", &HostHandle::renumber, arg("from_"), arg("masses"), arg("positions") = none, py::kw_only(),
           arg("index") = none, R"doc(
Points come and go. What only changes its number keeps its plan.

from_      int [n]: number i was from_[i], or is a new point where that is -1; those that are missing have left, and no
           constraint holds them any more
masses     float [n] of all
positions  float64 [n, 3], where the points are now; may be absent
index      int32 [n], as in constrain_positions)doc")
      .def("expect_edits", &ask<HostHandle, &Constrainer::expect_edits>,
           "Plans in parts from now on: a host that is going to edit says so at once, else its first edit plans all "
           "anew.")
      .def("update_plan", &ask<HostHandle, &Constrainer::update_plan>,
           "Does now what the next call would; returns how many islands were planned.")
      .def("rows", &rows, arg("id"),
           "The rows of a constraint as a slice: multipliers[c.rows(id)]. Rows are numbered in the order of ids.")
      .def("save", &HostHandle::save,
           "All that the next call depends on beside arrays, masses and constraints, as bytes for restore of a "
           "Constrainer with the same ones: it goes on to the last bit as this one does from now on.")
      .def("restore", &HostHandle::restore, arg("saved"),
           "Goes on from saved bytes. Raises InputError for bytes that are damaged or of other points or constraints.")
      .def("removed_degrees_of_freedom", &removed_degrees_of_freedom, arg("positions"), arg("flags"), py::kw_only(),
           arg("index") = none, arg("time") = 0.0,
           "The degrees of freedom that the constraints take at positions, float64 [n, 3], of the points with a flag, "
           "bool [n]: each independent row counts by its share of such points among those of its points that move.");
}

/// Binds observables.
void bind_observables(py::class_<HostHandle>* type) {
  using py::arg;
  const py::none none;
  type->def("add_observable", &HostHandle::add_observable, arg("what"), py::kw_only(), arg("name") = "",
            arg("unit") = "",
            R"doc(
Observes "max tension(rod0)", "load(support0)" and the like (docs/observables.md); returns the observable's number. All
supports together are support0. Only the caller knows the forces one by one, so there is no potential(), energy(),
pressure(), virial() and friction(). Raises InputError, with the column, if the text cannot be read.

what  its text
name  in results; the text if it is empty
unit  letters, "kJ/mol": the host's own, which nothing else knows)doc")
      .def("remove_observable", &HostHandle::remove_observable, arg("number"),
           "Removes an observable; those behind it move up by one.")
      .def("observe", &solve_host<&Constrainer::observe>, arg("positions"), arg("velocities"), arg("forces") = none,
           py::kw_only(), arg("accelerations") = none, arg("multipliers") = none, arg("constraint_forces") = none,
           arg("stress") = none, arg("index") = none, arg("time") = 0.0, arg("measures") = true, R"doc(
What solve does, and all observables there. Without forces nothing is solved; then no observable may need them. Raises
InputError, naming it, if an edit removed a thing of which an observable speaks.

positions, velocities, forces  float64 [n, 3]
The others as in solve.)doc")
      .def_property_readonly(
          "observed",
          [](HostHandle& handle) { return handle.run([](const Constrainer& c) { return list_of(c.observed()); }); },
          "(list[Observed]) the observables, with the values of the last observe; NaN before it");
}

}  // namespace

// NOLINTNEXTLINE(readability-function-size): a list
void bind_constrainer(py::module_& module) {
  using py::arg;
  const py::none none;
  py::class_<HostHandle> type(module, "Constrainer", constrainer_doc);
  type.def(py::init(&make_handle), arg("masses"), arg("constraints"), arg("positions"), py::kw_only(),
           arg("cell") = none, arg("repeats") = py::make_tuple(true, true, true), arg("images") = none,
           arg("options") = none)
      .def("constrain_positions", &constrain_positions, arg("step"), arg("old_positions"), arg("positions"),
           arg("velocities") = none, py::kw_only(), arg("multipliers") = none, arg("constraint_forces") = none,
           arg("stress") = none, arg("old_cell") = none, arg("index") = none, arg("time") = 0.0, arg("measures") = true,
           arg("tolerance") = 0.0, R"doc(
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
measures           finds correction, virial, largest turn, work and worst row; False saves that
tolerance          a largest |xi|/length that is small enough: iterations end there; 0: at rounding, below 1e-13)doc")
      .def("constrain_velocities", &constrain_velocities, arg("step"), arg("positions"), arg("velocities"),
           py::kw_only(), arg("multipliers") = none, arg("constraint_forces") = none, arg("stress") = none,
           arg("index") = none, arg("time") = 0.0, arg("measures") = true, R"doc(
RATTLE's second half: velocities += M^-1 K(r) nu, so that they obey the constraints at positions.

step        h: multipliers are 2 nu/h; 0: they are the impulses nu
positions   float64 [n, 3]
velocities  float64 [n, 3], written
The others as in constrain_positions.)doc")
      .def("solve", &solve_host<&Constrainer::solve>, arg("positions"), arg("velocities"), arg("forces"), py::kw_only(),
           arg("accelerations") = none, arg("multipliers") = none, arg("constraint_forces") = none,
           arg("stress") = none, arg("index") = none, arg("time") = 0.0, arg("measures") = true, R"doc(
Accelerations and multipliers of this instant, S lambda = -(phi + K'M^-1 f). The virial is exact.

positions, velocities, forces  float64 [n, 3]
accelerations                  float64 [n, 3], written: M^-1 (f + K lambda), 0 at supports
The others as in constrain_positions.)doc")
      .def("project_forces", &project_forces, arg("positions"), arg("forces"), py::kw_only(), arg("multipliers") = none,
           arg("constraint_forces") = none, arg("stress") = none, arg("index") = none, arg("time") = 0.0, R"doc(
forces += K lambda with S lambda = -K'M^-1 forces: what is left moves no constraint. For minimisers.

positions  float64 [n, 3]
forces     float64 [n, 3], written
The others as in constrain_positions.)doc")
      .def("project_positions", &project_host_positions, arg("positions"), py::kw_only(), arg("index") = none,
           arg("time") = 0.0,
           "The nearest positions on the constraints, in the norm of the masses, from anywhere; float64 [n, 3], "
           "written. For starts, before the first forces.")
      .def("log_det", &log_det, arg("positions"), arg("gradient") = none, py::kw_only(), arg("index") = none,
           arg("time") = 0.0,
           "ln det S at positions; gradient, float64 [n, 3], is written: its derivative in them. Fixman's "
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
      .def_property_readonly("plan", &ask<HostHandle, &Constrainer::plan>,
                             "(PlanSummary) how the equations are solved, and why so")
      .def_property_readonly("counters", &ask<HostHandle, &Constrainer::counters>,
                             "(Counters) work done so far by this handle")
      .def(py::pickle([](HostHandle& handle) { return handle.state(); }, &HostHandle::from_state));
  bind_edits(&type);
  bind_observables(&type);
}

}  // namespace tanor::python
