#include <tanor/error.hpp>

#include "python/bindings.hpp"

namespace tanor::python {

/// Binds tanor.InputError, a ValueError. Its text is "where: what", its attribute `where` the place.
void bind_errors(py::module_& module) {
  static const py::handle type = PyErr_NewExceptionWithDoc(
      "tanor.InputError",
      "Wrong input: what is wrong, with its value and the rule that it breaks. The attribute `where` is a JSON pointer "
      "into the description (\"/constraints/3/pairs/17\"), empty where there is no such place.",
      PyExc_ValueError, nullptr);
  module.attr("InputError") = type;
  py::register_exception_translator(
      [](std::exception_ptr thrown) {  // NOLINT(performance-unnecessary-value-param): as pybind11 has it
        try {
          if (thrown) std::rethrow_exception(thrown);
        } catch (const InputError& error) {
          const std::string place = error.where().empty() ? "" : error.where() + ": ";
          const py::object value = py::reinterpret_borrow<py::object>(type)(place + error.what());
          value.attr("where") = error.where();
          PyErr_SetObject(type.ptr(), value.ptr());
        }
      });
}

}  // namespace tanor::python
