#pragma once

#include <vector>

#include "python/values.hpp"

/// \file
/// Descriptions of a System, its kinds and the options. In Python they are plain objects that hold what the user gave
/// (tanor/description.py), made from the tables here. Therefore pickle and deepcopy keep them as they are.
namespace tanor::python {

/// Read the parts of a System or a Constrainer from the attributes of a Python object. They throw InputError.
System read_system(const py::object& system_or_scene);
Units read_units(const py::object& system_or_scene);
std::vector<Constraint> read_constraints(const py::object& constraints);

/// Returns the options that were given; for None those of the file of a Scene, or the defaults. `Options` are
/// SolverOptions, MotionOptions, EquilibriumOptions, ModesOptions or BucklingOptions. Throws InputError.
template <class Options>
Options choose_options(const py::object& options, const py::object& system_or_scene);

/// Returns the time at which the file of a Scene begins, or 0 for a System, s.
double start_of_scene(const py::object& system_or_scene);
/// Adds the observables and the events of a scene; of a system, the default observables.
void add_requests_of_scene(const py::object& system_or_scene, Simulation* simulation);
/// Returns the observables of a scene, or those that a system has where nothing is asked for.
std::vector<Observable> choose_observables(const py::object& system_or_scene, const System& system);
/// Returns name -> (first equation, members, equations a member) of each group of constraints, springs and bonds.
py::dict list_groups(const System& system);
/// Returns name -> tensions [members], from observables of the groups.
py::dict tensions_from(const std::vector<Observed>& of_groups);

/// Returns the letters of each quantity by its name.
py::dict letters_of(const Units& units);

/// Returns what C++ holds as an object of Python's class: `read_system` of it is the same system.
py::object give_system(const System& system);
/// Returns the options of the file of a Scene, or the defaults, as an object of Python's class.
template <class Options>
py::object give_options(const py::object& system_or_scene);
/// Puts options that stand by their fields' names, as in Simulation(system, rtol=1e-10), into those that were given
/// whole or are those of the scene. Throws TypeError for a name that neither Options nor SolverOptions have.
template <class Options>
void take_named_options(const char* what, const py::object& system_or_scene, const py::kwargs& named,
                        py::object* options, py::object* solver);

/// Binds checks of a whole System, as the library has them.
void bind_system_functions(py::module_& module);

/// Returns the tables of all kinds and options for tanor/description.py: a list of {"list", "name", "kind", "doc",
/// "fields"}, a field being (name, annotation, text, default, is_required).
py::list descriptions();

}  // namespace tanor::python
