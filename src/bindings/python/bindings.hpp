#pragma once

#include "python/call.hpp"

/// \file
/// The parts of the module, one function a file.
namespace tanor::python {

void bind_errors(py::module_& module);
void bind_reports(py::module_& module);
void bind_constrainer(py::module_& module);
void bind_dynamics(py::module_& module);
void bind_scalar(py::module_& module);
void bind_scene(py::module_& module);
void bind_simulation(py::module_& module);
void bind_statics(py::module_& module);

}  // namespace tanor::python
