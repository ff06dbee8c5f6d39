#include "python/scalar.hpp"

#include <pybind11/numpy.h>
#include <pybind11/operators.h>

#include <utility>

#include "python/bindings.hpp"

namespace tanor::python {
namespace {

/// A number of a function that is being recorded. It may outlive the expression that it belongs to, but cannot be used
/// any more then.
struct Scalar {
  Traced value;
  std::shared_ptr<const bool> is_recording{};  // null for a constant
};

using Recording = std::shared_ptr<bool>;

const Traced& value_of(const Scalar& number) {
  if (number.is_recording != nullptr && !*number.is_recording)
    throw py::value_error("a number of a Definition was kept after the call; it belongs to that call alone");
  return number.value;
}

template <class Operation>
auto of_one(const Operation& operation) {
  return [operation](const Scalar& a) { return Scalar{operation(value_of(a)), a.is_recording}; };
}

template <class Operation>
auto of_two(const Operation& operation) {
  return [operation](const Scalar& a, const Scalar& b) {
    const Traced &x = value_of(a), &y = value_of(b);
    if (a.is_recording != nullptr && b.is_recording != nullptr && a.is_recording != b.is_recording)
      throw py::value_error("numbers of two Definitions meet");
    return Scalar{operation(x, y), a.is_recording != nullptr ? a.is_recording : b.is_recording};
  };
}

[[noreturn]] bool refuse_comparison(const Scalar&, const py::object&) {
  throw py::type_error(
      "a Definition does not compare its numbers, it is called once for all; abs, min and max are right, or a callable "
      "that returns (energy, gradient, hessian)");
}

/// Returns x, y, z as an array of numpy, so that whole vectors can be added, crossed and multiplied.
py::object vector_of(const Scalar& x, const Scalar& y, const Scalar& z) {
  return py::module_::import("numpy").attr("array")(py::make_tuple(x, y, z), py::arg("dtype") = py::dtype("O"));
}

}  // namespace

std::shared_ptr<const Expression> record_energy(const Given& definition, int num_points,
                                                const std::vector<std::string>& constants) {
  const auto p = static_cast<std::size_t>(num_points);
  const int num_variables = 3 * num_points + static_cast<int>(constants.size()) + 1;
  const Recording is_recording = std::make_shared<bool>(true);
  const struct Ended {
    const Recording& recording;
    ~Ended() { *recording = false; }
  } ended{is_recording};
  return record_expression(num_variables, [&](const std::vector<Traced>& x) {
    const auto number = [&](std::size_t i) { return Scalar{x[i], is_recording}; };
    py::list arguments;
    for (std::size_t i = 0; i < p; ++i)
      arguments.append(vector_of(number(3 * i), number(3 * i + 1), number(3 * i + 2)));
    arguments.append(number(x.size() - 1));
    py::dict named;
    for (std::size_t i = 0; i < constants.size(); ++i) named[py::str(constants[i])] = number(3 * p + i);
    const py::object result = definition.value.attr("function")(*arguments, **named);
    try {
      return std::vector<Traced>{value_of(result.cast<Scalar>())};
    } catch (const py::cast_error&) {
      Given{result, definition.place}.fail("one number, the energy in J, from the function of a Definition");
    }
  });
}

void bind_scalar(py::module_& module) {
  py::class_<Scalar> type(module, "Scalar", py::module_local(), R"doc(
A number that the function of a Definition computes with. It knows + - * / **, abs, and the functions of numpy on it and
on arrays of it: sqrt, exp, log, sin, cos, tan, arcsin, arccos, arctan, arctan2, sinh, cosh, tanh, square, cross, dot,
linalg.norm. It has no value: a function of the module math, and an `if`, cannot take it.
)doc");
  type.def(py::init([](double constant) { return Scalar{constant}; }), py::arg("constant"));
  py::implicitly_convertible<py::float_, Scalar>();
  py::implicitly_convertible<py::int_, Scalar>();

  const auto binary = [&](const char* name, const char* reversed, const auto& operation) {
    type.def(name, of_two(operation), py::is_operator());
    type.def(
        reversed, [both = of_two(operation)](const Scalar& a, const Scalar& b) { return both(b, a); },
        py::is_operator());
  };
  binary("__add__", "__radd__", [](const Traced& a, const Traced& b) { return a + b; });
  binary("__sub__", "__rsub__", [](const Traced& a, const Traced& b) { return a - b; });
  binary("__mul__", "__rmul__", [](const Traced& a, const Traced& b) { return a * b; });
  binary("__truediv__", "__rtruediv__", [](const Traced& a, const Traced& b) { return a / b; });
  binary("__pow__", "__rpow__", [](const Traced& a, const Traced& b) { return pow(a, b); });
  type.def("__neg__", of_one([](const Traced& a) { return -a; }));
  type.def("__pos__", of_one([](const Traced& a) { return a; }));
  type.def("__abs__", of_one([](const Traced& a) { return abs(a); }));
  for (const char* comparison : {"__lt__", "__le__", "__gt__", "__ge__", "__eq__", "__ne__"})
    type.def(comparison, &refuse_comparison);
  type.def("__bool__", [](const Scalar& a) { return refuse_comparison(a, py::none()); });

  // The names are those by which numpy calls its functions on numbers that are none of its own.
  const auto unary = [&](const char* name, const auto& operation) {
    type.def(name, of_one(operation), ("As numpy." + std::string(name) + ".").c_str());
  };
  unary("sqrt", [](const Traced& a) { return sqrt(a); });
  unary("exp", [](const Traced& a) { return exp(a); });
  unary("log", [](const Traced& a) { return log(a); });
  unary("sin", [](const Traced& a) { return sin(a); });
  unary("cos", [](const Traced& a) { return cos(a); });
  unary("tan", [](const Traced& a) { return tan(a); });
  unary("arcsin", [](const Traced& a) { return asin(a); });
  unary("arccos", [](const Traced& a) { return acos(a); });
  unary("arctan", [](const Traced& a) { return atan(a); });
  unary("sinh", [](const Traced& a) { return sinh(a); });
  unary("cosh", [](const Traced& a) { return cosh(a); });
  unary("tanh", [](const Traced& a) { return tanh(a); });
  type.def("arctan2", of_two([](const Traced& y, const Traced& x) { return atan2(y, x); }), py::arg("x"),
           "As numpy.arctan2.");
  type.def("min", of_two([](const Traced& a, const Traced& b) { return min(a, b); }), py::arg("other"),
           "The smaller one of two.");
  type.def("max", of_two([](const Traced& a, const Traced& b) { return max(a, b); }), py::arg("other"),
           "The larger one of two.");
}

}  // namespace tanor::python
