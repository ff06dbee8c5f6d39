#pragma once

#include <vector>

#include "python/values.hpp"

/// \file
/// Descriptions: System, its kinds, the options. In Python they are plain objects that hold what the user gave
/// (tanor/description.py), made of the tables here; pickle and deepcopy therefore keep them as they are.
namespace tanor::python {

/// What a System or a Constrainer is made of. Each reads the attributes of a Python object; throws InputError.
System read_system(const py::object& system_or_scene);
std::vector<Constraint> read_constraints(const py::object& constraints);
SolverOptions read_solver_options(const py::object& options);
MotionOptions read_motion_options(const py::object& options);
EquilibriumOptions read_equilibrium_options(const py::object& options);
ModesOptions read_modes_options(const py::object& options);
BucklingOptions read_buckling_options(const py::object& options);

/// What the file of a Scene says; the defaults for a System.
SolverOptions options_of_scene(const py::object& system_or_scene);
MotionOptions motion_of_scene(const py::object& system_or_scene);

/// Checks of a whole System, as the library has them.
void bind_system_functions(py::module_& module);

/// The tables of all kinds and options for tanor/description.py: a list of {"list", "name", "kind", "doc", "fields"},
/// a field being (name, annotation, text, default, is_required).
py::list descriptions();

}  // namespace tanor::python
