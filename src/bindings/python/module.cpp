#include <tanor/version.hpp>

#include "python/bindings.hpp"
#include "python/kinds.hpp"

/// The compiled part of the package `tanor`, which tanor/__init__.py exports.
PYBIND11_MODULE(_core, module) {
  using namespace tanor::python;
  module.doc() = "The compiled part of tanor.";
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
