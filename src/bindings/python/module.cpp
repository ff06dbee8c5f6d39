#include <tanor/version.hpp>

#include <string>

#include "python/bindings.hpp"
#include "python/kinds.hpp"

/// The compiled part of the package `tanor`, which tanor/__init__.py exports.
PYBIND11_MODULE(_core, module) {
  using namespace tanor::python;
  module.doc() = "The compiled part of tanor.";
  // Older versions of pybind11 read the types of numpy 2 wrongly.
  const auto numpy = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (PYBIND11_VERSION_HEX < 0x020C0000 && std::stoi(numpy) >= 2)
    throw py::import_error("this build of tanor needs numpy 1, found numpy " + numpy);
  bind_errors(module);
  bind_reports(module);
  bind_scene(module);
  bind_constrainer(module);
  bind_dynamics(module);
  bind_simulation(module);
  bind_statics(module);
  bind_scalar(module);
  bind_system_functions(module);
  module.def("_descriptions", &descriptions);
  module.attr("__version__") = TANOR_VERSION;
}
