#include "python/functions.hpp"

#include <tanor/recorded.hpp>

#include <pybind11/numpy.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include "python/arrays.hpp"
#include "python/scalar.hpp"

namespace tanor::python {
namespace {

/// A text with the constants that it names: a str, or a Formula.
struct Text {
  py::object text;
  Constants constants;
};

Text text_of(const Given& given) {
  if (!py::hasattr(given.value, "constants")) return {given.value, {}};
  Text text{given.value.attr("text"), {}};
  for (const auto& [name, number] : given.value.attr("constants").cast<py::dict>())
    text.constants.emplace(name.cast<std::string>(), number.cast<double>());
  return text;
}

std::vector<std::string> texts_of(const Given& given, const Text& text, const char* wanted) {
  std::vector<std::string> texts;
  for (const Given& each : Given{text.text, given.place}.entries(wanted)) read(each, &texts.emplace_back());
  return texts;
}

/// Adds the place of a text to what the library says of it.
template <class Make>
auto locate(const Given& given, const Make& make) {
  try {
    return make();
  } catch (const InputError& error) {
    throw InputError(given.place, error.what());
  }
}

/// Returns f(t) and its derivatives, with the jet of t inserted.
Jet<2> compose(const std::array<double, 3>& f, const Jet<2>& t) {
  Jet<2> result(f[0]);
  // (f o t)(e) = f + f' t1 e + (f' t2 + f'' t1^2/2) e^2
  result.c[1] = f[1] * t.c[1];
  result.c[2] = f[1] * t.c[2] + 0.5 * f[2] * t.c[1] * t.c[1];
  return result;
}

/// Returns what a function of a user returned as a packed array. Throws unless it has the given number of values.
py::array_t<double> result_of(const py::handle& result, py::ssize_t size, const char* what) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(result);
  if (!array) {
    throw py::value_error("a function returned " + py::repr(result).cast<std::string>() + " for " + what +
                          ", wanted are " + std::to_string(size) + " numbers");
  }
  if (array.size() != size) {
    throw py::value_error(std::string("a function returned ") + std::to_string(array.size()) + " numbers for " + what +
                          ", wanted are " + std::to_string(size));
  }
  return array;
}

void copy_result(const py::handle& result, std::size_t size, const char* what, double* to) {
  const auto array = result_of(result, static_cast<py::ssize_t>(size), what);
  std::copy_n(array.data(), size, to);
}

/// Returns a read-only array of the given shape on numbers that the library lends for the time of a call.
py::array lend(const double* numbers, std::vector<py::ssize_t> shape) {
  py::array array(py::dtype::of<double>(), std::move(shape), numbers, py::none());
  array.attr("flags").attr("writeable") = false;
  return array;
}

/// Returns the parts of a tuple that a function returned.
std::vector<py::object> parts_of(const py::object& result, std::size_t count, const char* wanted) {
  if (!py::isinstance<py::tuple>(result) || py::len(result) != count)
    throw py::type_error(std::string("a function returned ") + py::repr(py::type::of(result)).cast<std::string>() +
                         ", wanted is the tuple " + wanted);
  std::vector<py::object> parts;
  for (const py::handle part : result) parts.push_back(py::reinterpret_borrow<py::object>(part));
  return parts;
}

/// Evaluates a force. `p` is the number of points of a tuple, 0 if each point stands alone.
void evaluate_force(const py::object& call, const ForceBatch& batch, py::ssize_t p) {
  const auto k = static_cast<py::ssize_t>(batch.count);
  const std::vector<py::ssize_t> shape = p > 0 ? std::vector{k, p, py::ssize_t{3}} : std::vector{k, py::ssize_t{3}};
  copy_result(call(batch.t, lend(batch.r, shape), lend(batch.v, shape)),
              3 * batch.count * static_cast<std::size_t>(std::max(p, py::ssize_t{1})),
              p > 0 ? "forces [k, p, 3]" : "forces [k, 3]", batch.f);
}

void evaluate_constraint(const py::object& call, const ConstraintBatch& batch, py::ssize_t p) {
  const auto k = static_cast<py::ssize_t>(batch.count);
  const std::size_t size = 3 * static_cast<std::size_t>(p) * batch.count;
  // The library also asks for values alone; the velocities are then zero.
  const std::vector<double> rest(batch.rate == nullptr ? size : 0, 0.0);
  const auto parts =
      parts_of(call(batch.t, lend(batch.r, {k, p, 3}), lend(batch.rate == nullptr ? rest.data() : batch.v, {k, p, 3})),
               4, "(xi, gradient, rate, phi)");
  copy_result(parts[0], batch.count, "xi [k]", batch.xi);
  if (batch.gradient != nullptr) copy_result(parts[1], size, "the gradient [k, p, 3]", batch.gradient);
  if (batch.rate == nullptr) return;
  copy_result(parts[2], batch.count, "the rate [k]", batch.rate);
  copy_result(parts[3], batch.count, "phi [k]", batch.phi);
}

void evaluate_potential(const py::object& call, const PotentialBatch& batch, py::ssize_t p) {
  const auto k = static_cast<py::ssize_t>(batch.count);
  const std::size_t size = 3 * static_cast<std::size_t>(p);
  const auto parts = parts_of(call(lend(batch.r, {k, p, 3})), 3, "(energy, gradient, hessian)");
  copy_result(parts[0], batch.count, "the energy [k]", batch.energy);
  if (batch.gradient != nullptr) copy_result(parts[1], size * batch.count, "the gradient [k, p, 3]", batch.gradient);
  if (batch.hessian == nullptr) return;
  if (parts[2].is_none()) throw py::value_error("the method asks for the hessian of an energy, which is None");
  copy_result(parts[2], size * size * batch.count, "the hessian [k, 3p, 3p]", batch.hessian);
}

void evaluate_friction(const py::object& call, const FrictionBatch& batch, py::ssize_t p) {
  const auto k = static_cast<py::ssize_t>(batch.count);
  const auto parts = parts_of(call(batch.t, lend(batch.r, {k, 3}), lend(batch.v, {k, 3}), lend(batch.lambda, {k, p})),
                              2, "(tau, derivative)");
  copy_result(parts[0], 3 * batch.count, "tau [k, 3]", batch.tau);
  if (batch.derivative != nullptr)
    copy_result(parts[1], 3 * batch.count * static_cast<std::size_t>(p), "the derivative [k, 3, p]", batch.derivative);
}

/// Makes the kernel of a callable, which evaluate(callable, batch, size) calls.
template <auto evaluate, class Kernel>
void take_callable(const Given& given, int size, Kernel* kernel) {
  struct Function {
    Shared callable;
    py::ssize_t size;
  };
  kernel->thread_safe = false;
  kernel->context = std::make_shared<const Function>(Function{Shared(given.value), size});
  kernel->evaluate = [](const void* context, const auto& batch) {
    const py::gil_scoped_acquire acquired;
    const auto& function = *static_cast<const Function*>(context);
    evaluate(*function.callable, batch, function.size);
  };
}

bool is_callable(const Given& given) {
  return PyCallable_Check(given.value.ptr()) != 0;
}

ScalarFunction column_of_table(const Given& given, std::size_t columns, std::size_t column, const char* what) {
  std::vector<double> times;
  read(given["times"], &times);
  const auto values = result_of(given.value.attr("values"), static_cast<py::ssize_t>(columns * times.size()), what);
  std::vector<double> numbers;
  for (std::size_t k = 0; k < times.size(); ++k) numbers.push_back(values.data()[columns * k + column]);
  return locate(given, [&] { return ScalarFunction::table(times, numbers); });
}

}  // namespace

ScalarFunction function_of_time(const Given& given) {
  if (py::hasattr(given.value, "times")) return column_of_table(given, 1, 0, "values [times]");
  if (is_callable(given)) {
    return ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)>([f = Shared(given.value)](const Jet<2>& t) {
      const py::gil_scoped_acquire acquired;
      std::array<double, 3> numbers{};
      copy_result((*f)(t.value()), 3, "(value, first derivative, second derivative)", numbers.data());
      return compose(numbers, t);
    }));
  }
  const Text text = text_of(given);
  if (!py::isinstance<py::str>(text.text))
    given.fail("a number, a formula in t, a Formula, a Table or a callable of time");
  return locate(given, [&] { return ScalarFunction::formula(text.text.cast<std::string>(), text.constants); });
}

VectorFunction vector_function_of_time(const Given& given) {
  VectorFunction result;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (py::hasattr(given.value, "times")) {
      result.components[axis] = column_of_table(given, 3, axis, "values [times, 3]");
      continue;
    }
    result.components[axis] =
        ScalarFunction::custom(std::function<Jet<2>(const Jet<2>&)>([f = Shared(given.value), axis](const Jet<2>& t) {
          const py::gil_scoped_acquire acquired;
          const auto numbers = result_of((*f)(t.value()), 9, "(value, first, second derivative), [3] each");
          const double* const x = numbers.data() + axis;
          return compose({x[0], x[3], x[6]}, t);
        }));
  }
  return result;
}

void read(const Given& given, int num_points, ForceKernel* kernel) {
  if (is_callable(given)) {
    kernel->num_points = std::max(num_points, 1);
    return take_callable<evaluate_force>(given, num_points, kernel);
  }
  const Text text = text_of(given);
  constexpr const char* wanted = "three formulas (for each point of a tuple) or a callable (t, r, v)";
  const std::vector<std::string> texts = texts_of(given, text, wanted);
  if (texts.empty() || texts.size() % 3 != 0) given.fail(wanted);
  *kernel = locate(given, [&] {
    return texts.size() == 3 ? formula_force({texts[0], texts[1], texts[2]}, text.constants)
                             : formula_tuple_force(texts, text.constants);
  });
}

void read(const Given& given, int num_points, ConstraintKernel* kernel) {
  if (is_callable(given)) {
    kernel->num_points = num_points;
    return take_callable<evaluate_constraint>(given, num_points, kernel);
  }
  const Text text = text_of(given);
  if (!py::isinstance<py::str>(text.text)) given.fail("a formula, a Formula or a callable (t, r, v)");
  *kernel =
      locate(given, [&] { return formula_constraint(text.text.cast<std::string>(), num_points, text.constants); });
}

void read(const Given& given, int num_points, const std::vector<std::string>& own_constants, PotentialKernel* kernel) {
  if (is_callable(given)) {
    if (!own_constants.empty()) given.fail("a text or a Definition, where there are constants");
    kernel->num_points = num_points;
    kernel->depends_on_time = false;
    return take_callable<evaluate_potential>(given, num_points, kernel);
  }
  if (py::hasattr(given.value, "function")) {
    auto energy = record_energy(given, num_points, own_constants);
    *kernel = locate(given, [&] {
      return expression_potential(std::move(energy), num_points, static_cast<int>(own_constants.size()));
    });
    return;
  }
  const Text text = text_of(given);
  if (!py::isinstance<py::str>(text.text)) given.fail("a formula, a Formula, a Definition or a callable of r");
  *kernel = locate(given, [&] {
    return formula_potential(text.text.cast<std::string>(), num_points, text.constants, own_constants);
  });
}

void read(const Given& given, int num_multipliers, FrictionKernel* kernel) {
  if (!is_callable(given)) given.fail("a callable (t, r, v, multipliers)");
  kernel->num_multipliers = num_multipliers;
  take_callable<evaluate_friction>(given, num_multipliers, kernel);
}

void read(const Given& given, const std::vector<std::string>& names, CoordinateKernel* kernel) {
  const Text text = text_of(given);
  const std::vector<std::string> texts = texts_of(given, text, "formulas x, y, z of each point");
  *kernel = locate(given, [&] { return formula_coordinates(names, texts, text.constants); });
}

}  // namespace tanor::python
