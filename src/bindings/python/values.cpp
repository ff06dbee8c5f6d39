#include "python/values.hpp"

#include <pybind11/numpy.h>

#include <limits>
#include <utility>

#include "python/functions.hpp"

namespace tanor::python {
namespace {

bool is_number(const py::object& value) {
  const auto* const array = py::isinstance<py::array>(value) ? py::detail::array_proxy(value.ptr()) : nullptr;
  return PyFloat_Check(value.ptr()) != 0 || (array != nullptr && array->nd == 0) ||
         (PyNumber_Check(value.ptr()) != 0 && !py::isinstance<py::str>(value) && PySequence_Check(value.ptr()) == 0);
}

using WholeNumbers = py::array_t<std::int64_t, py::array::c_style | py::array::forcecast>;

/// Returns an array of whole numbers. An empty list is one.
WholeNumbers whole_numbers(const Given& given, py::ssize_t dimensions, const char* wanted) {
  auto array = py::array::ensure(given.value);
  PyErr_Clear();
  if (array && array.size() == 0) return {};
  if (array && array.ndim() == 0 && dimensions == 1) array = array.reshape({1});  // a number is a list of one
  if (!array || (array.dtype().kind() != 'i' && array.dtype().kind() != 'u') || array.ndim() != dimensions)
    given.fail(wanted);
  return WholeNumbers::ensure(array);
}

/// Takes the rows of an array of whole numbers that Index can hold; 0 columns are any number of them.
template <class Take>
void take_indices(const Given& given, py::ssize_t dimensions, py::ssize_t columns, const char* wanted,
                  const Take& take) {
  const WholeNumbers numbers = whole_numbers(given, dimensions, wanted);
  if (numbers.size() == 0) return;
  const py::ssize_t width = dimensions == 1 ? 1 : numbers.shape(1);
  if (columns > 0 && width != columns) given.fail(wanted);
  std::vector<Index> row(static_cast<std::size_t>(width));
  for (py::ssize_t k = 0; k < numbers.shape(0); ++k) {
    for (py::ssize_t p = 0; p < width; ++p) {
      const std::int64_t number = numbers.data()[k * width + p];
      if (number < 0 || number > std::numeric_limits<Index>::max())
        Given{py::int_(number), given.place + "/" + std::to_string(k)}.fail("the number of a point, 0 or more");
      row[static_cast<std::size_t>(p)] = static_cast<Index>(number);
    }
    take(row);
  }
}

/// Returns a packed array of doubles, of three dimensions if the value is no array of numbers.
py::array_t<double> numbers_of(const py::object& value) {
  const auto raw = py::array::ensure(value);
  PyErr_Clear();
  if (!raw || (raw.size() > 0 && std::string("fiub").find(raw.dtype().kind()) == std::string::npos))
    return py::array_t<double>({0, 0, 0});
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(raw);
}

/// Calls visit(name, value) for each entry of a dict.
template <class Visit>
void for_each_entry(const Given& given, const std::string& wanted, const Visit& visit) {
  if (py::len(given.value) == 0) return;
  if (!py::isinstance<py::dict>(given.value)) given.fail(wanted);
  for (const auto& [name, value] : given.value.cast<py::dict>())
    visit(name.template cast<std::string>(), py::reinterpret_borrow<py::object>(value));
}

/// Calls visit(name, numbers) for each entry of a dict. A number is a list of one.
template <class Visit>
void for_each_list(const Given& given, const char* wanted, const Visit& visit) {
  for_each_entry(given, wanted, [&](std::string name, const py::object& numbers) {
    const auto array = numbers_of(numbers);
    if (array.ndim() > 1 || array.size() == 0) given.fail(wanted);
    visit(std::move(name), std::vector<double>(array.data(), array.data() + array.size()));
  });
}

}  // namespace

void Given::fail(const std::string& wanted) const {
  auto found = py::module_::import("tanor.description").attr("short")(value).cast<std::string>();
  if (found.size() > 80) found = found.substr(0, 77) + "...";
  throw InputError(place, "found " + found + ", wanted " + wanted);
}

Given Given::operator[](const char* name) const {
  return {value.attr(name), place + "/" + name};
}

std::vector<Given> Given::entries(const char* wanted) const {
  if (py::isinstance<py::str>(value) || PySequence_Check(value.ptr()) == 0) fail(wanted);
  std::vector<Given> result;
  for (const py::handle entry : value)
    result.push_back({py::reinterpret_borrow<py::object>(entry), place + "/" + std::to_string(result.size())});
  return result;
}

void read(const Given& given, bool* flag) {
  if (!py::isinstance<py::bool_>(given.value)) given.fail("True or False");
  *flag = given.value.cast<bool>();
}

void read(const Given& given, int* number) {
  if (PyIndex_Check(given.value.ptr()) == 0) given.fail("a whole number");
  *number = given.value.cast<int>();
}

void read(const Given& given, std::size_t* count) {
  if (py::isinstance<py::str>(given.value) && given.value.cast<std::string>() == "all") {
    *count = std::numeric_limits<std::size_t>::max();
    return;
  }
  if (PyIndex_Check(given.value.ptr()) == 0 || py::int_(given.value).cast<long long>() < 0)
    given.fail("a whole number, 0 or more, or \"all\"");
  *count = py::int_(given.value).cast<std::size_t>();
}

void read(const Given& given, double* number) {
  if (!is_number(given.value)) given.fail("a number");
  *number = py::float_(given.value);
}

void read(const Given& given, std::optional<double>* number) {
  if (given.value.is_none()) return number->reset();
  read(given, &number->emplace());
}

void read(const Given& given, std::string* text) {
  if (!py::isinstance<py::str>(given.value)) given.fail("a text");
  *text = given.value.cast<std::string>();
}

void read(const Given& given, Vector3* vector) {
  const auto numbers = numbers_of(given.value);
  if (numbers.ndim() != 1 || numbers.size() != 3) given.fail("three numbers");
  std::copy_n(numbers.data(), 3, vector->begin());
}

void read(const Given& given, std::array<Vector3, 2>* vectors) {
  std::vector<Vector3> list;
  read(given, &list);
  if (list.size() != vectors->size()) given.fail("numbers [2, 3]");
  std::ranges::copy(list, vectors->begin());
}

void read(const Given& given, ScalarFunction* function) {
  if (is_number(given.value)) {
    *function = py::float_(given.value).operator double();
  } else {
    *function = function_of_time(given);
  }
}

void read(const Given& given, VectorFunction* function) {
  if (PyCallable_Check(given.value.ptr()) != 0 || py::hasattr(given.value, "times")) {
    *function = vector_function_of_time(given);
    return;
  }
  constexpr const char* wanted = "three numbers or functions of time, or one callable of time";
  const std::vector<Given> components = given.entries(wanted);
  if (components.size() != 3) given.fail(wanted);
  for (std::size_t k = 0; k < 3; ++k) read(components[k], &function->components[k]);
}

void read(const Given& given, Parameter* parameter) {
  const bool is_text = py::isinstance<py::str>(given.value);
  if (given.value.is_none() || (is_text && given.value.cast<std::string>() == "initial")) {
    *parameter = {};
  } else if (is_number(given.value)) {
    *parameter = py::float_(given.value).operator double();
  } else if (is_text || PySequence_Check(given.value.ptr()) == 0) {
    *parameter = function_of_time(given);
  } else if (const auto numbers = numbers_of(given.value); numbers.ndim() == 1 && numbers.size() > 0) {
    *parameter = std::vector<double>(numbers.data(), numbers.data() + numbers.size());
  } else {
    std::vector<ScalarFunction> functions;
    for (const Given& each : given.entries("a number or function of time for each"))
      read(each, &functions.emplace_back());
    *parameter = std::move(functions);
  }
}

void read(const Given& given, Method* method) {
  std::string word;
  read(given, &word);
  try {
    *method = method_from_name(word);
  } catch (const InputError& error) {
    throw InputError(given.place, error.what());
  }
}

void read(const Given& given, std::vector<std::string>* names) {
  if (py::isinstance<py::str>(given.value)) {
    names->assign(1, given.value.cast<std::string>());
  } else {
    names->clear();
    for (const Given& name : given.entries("a name or a list of names")) read(name, &names->emplace_back());
  }
}

void read(const Given& given, std::vector<double>* numbers) {
  const auto array = numbers_of(given.value);
  if (array.ndim() > 1) given.fail("a list of numbers");  // a number is a list of one
  numbers->assign(array.data(), array.data() + array.size());
}

void read(const Given& given, std::vector<Vector3>* vectors) {
  const auto array = numbers_of(given.value);
  vectors->clear();
  if (array.size() == 0 && array.ndim() < 3 && array.ndim() > 0 && array.shape(0) == 0) return;
  if (array.ndim() != 2 || array.shape(1) != 3) given.fail("numbers [n, 3]");
  for (py::ssize_t k = 0; k < array.shape(0); ++k)
    std::copy_n(array.data() + 3 * k, 3, vectors->emplace_back().begin());
}

void read(const Given& given, std::vector<std::int64_t>* numbers) {
  const WholeNumbers whole = whole_numbers(given, 1, "whole numbers [n]");
  numbers->assign(whole.data(), whole.data() + whole.size());
}

void read(const Given& given, std::vector<Index>* points) {
  points->clear();
  take_indices(given, 1, 0, "a list of points, whole numbers [n]",
               [&](const std::vector<Index>& row) { points->push_back(row[0]); });
}

template <std::size_t N>
void read(const Given& given, std::vector<std::array<Index, N>>* tuples) {
  constexpr std::array wanted{"pairs of points, whole numbers [n, 2]", "triples of points, whole numbers [n, 3]",
                              "quadruples of points, whole numbers [n, 4]"};
  tuples->clear();
  take_indices(given, 2, N, wanted[N - 2], [&](const std::vector<Index>& row) {
    std::copy(row.begin(), row.end(), tuples->emplace_back().begin());
  });
}
template void read(const Given& given, std::vector<std::array<Index, 2>>* tuples);
template void read(const Given& given, std::vector<std::array<Index, 3>>* tuples);
template void read(const Given& given, std::vector<std::array<Index, 4>>* tuples);

void read(const Given& given, std::vector<std::vector<double>>* constants) {
  constants->clear();
  for_each_list(given, "a dict of names, each with a number or one number a tuple",
                [&](const std::string&, std::vector<double> numbers) { constants->push_back(std::move(numbers)); });
}

void read(const Given& given, std::vector<Prestress>* prestress) {
  prestress->clear();
  for_each_list(given, "a dict of names of rods, each with a tension or one tension a rod",
                [&](std::string name, std::vector<double> tensions) {
                  prestress->push_back({std::move(name), std::move(tensions)});
                });
}

void read(const Given& given, ContactOptions* contact) {
  for_each_entry(given, "a dict of limits", [&](const std::string& name, const py::object& value) {
    const Given own{value, given.place + "/" + name};
    if (name == "max_at_one_instant") return read(own, &contact->max_at_one_instant);
    if (name == "max_events") return read(own, &contact->max_events);
    own.fail("\"max_at_one_instant\" or \"max_events\"");
  });
}

void read(const Given& given, std::vector<OneSided>* sides) {
  sides->clear();
  for_each_entry(given, "a dict of names of constraints, each with one of " + words_of<OneSide>(),
                 [&](std::string name, py::object side) {
                   OneSided& each = sides->emplace_back(OneSided{std::move(name)});
                   read({std::move(side), given.place + "/" + each.constraint}, &each.side);
                 });
}

void read(const Given& given, std::vector<std::vector<Index>>* tuples) {
  tuples->clear();
  take_indices(given, 2, 0, "tuples of points, whole numbers [n, p]",
               [&](const std::vector<Index>& row) { tuples->push_back(row); });
}

}  // namespace tanor::python
