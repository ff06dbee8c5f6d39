#include "python/arrays.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace tanor::python {
namespace {

constexpr py::ssize_t number_size = sizeof(double);

std::string shape_of(const py::array& array) {
  return py::str(py::list(array.attr("shape"))).cast<std::string>();
}

std::string shape_of(const Wanted& wanted) {
  const std::string rows = wanted.rows ? std::to_string(*wanted.rows) : "n";
  return wanted.columns > 0 ? "[" + rows + ", " + std::to_string(wanted.columns) + "]" : "[" + rows + "]";
}

std::vector<py::ssize_t> shape_of(std::span<const double> numbers, py::ssize_t columns) {
  const auto size = static_cast<py::ssize_t>(numbers.size());
  return columns > 0 ? std::vector{size / columns, columns} : std::vector{size};
}

/// Returns an array of Numbers in the wanted shape. Names are made for errors alone: hosts call with small arrays, too.
template <class Number>
py::array take(const py::object& object, const Wanted& wanted) {
  const auto name = [&] { return std::string(wanted.name); };
  const auto kind = [] { return py::str(py::dtype::of<Number>()).cast<std::string>(); };
  if (!py::isinstance<py::array>(object)) {
    throw py::type_error(name() + ": found " + py::str(py::type::of(object).attr("__name__")).cast<std::string>() +
                         ", wanted a numpy array of " + kind() + " " + shape_of(wanted));
  }
  auto array = py::reinterpret_borrow<py::array>(object);
  if (!py::isinstance<py::array_t<Number>>(array)) {
    throw py::type_error(name() + ": found numbers of type " + py::str(array.dtype()).cast<std::string>() +
                         ", wanted " + kind());
  }
  const bool has_shape = array.ndim() == (wanted.columns > 0 ? 2 : 1) &&
                         (!wanted.rows || array.shape(0) == *wanted.rows) &&
                         (wanted.columns == 0 || array.shape(1) == wanted.columns);
  if (!has_shape)
    throw py::value_error(name() + ": found the shape " + shape_of(array) + ", wanted " + shape_of(wanted));
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0)
    throw py::value_error(name() + ": its numbers are not aligned in memory; take a copy of the array");
  return array;
}

void require_writeable(const py::array& array, const Wanted& wanted) {
  if (array.writeable()) return;
  throw py::value_error(std::string(wanted.name) + ": it is read-only, and the result is written into it");
}

void require_packed(const py::array& array, const Wanted& wanted) {
  if ((array.flags() & py::array::c_style) != 0) return;
  throw py::value_error(std::string(wanted.name) +
                        ": its numbers have gaps or another order than C's; wanted a packed array");
}

template <class Number>
BasicPointArray<Number> points_of(const py::array& array, void* data, const Wanted& wanted,
                                  std::span<const Index> index) {
  if (array.shape(0) > 0 && array.strides(1) != number_size) {
    throw py::value_error(std::string(wanted.name) +
                          ": the three numbers of a point do not follow one another in memory (the array is transposed "
                          "or in Fortran's order); any distance between points is right");
  }
  if (array.shape(0) > 1 && array.strides(0) == 0)
    throw py::value_error(std::string(wanted.name) + ": all its rows are the same memory");
  for (const Index i : index) {
    if (i >= 0 && i < array.shape(0)) continue;
    throw py::value_error(std::string(wanted.name) + ": the index names row " + std::to_string(i) + " of " +
                          std::to_string(array.shape(0)));
  }
  return {static_cast<Number*>(data), array.shape(0) > 1 ? array.strides(0) : 0,
          index.empty() ? nullptr : index.data()};
}

}  // namespace

ConstPointArray points_to_read(const py::object& object, const Wanted& wanted, std::span<const Index> index) {
  if (object.is_none()) return {};
  const py::array array = take<double>(object, wanted);
  return points_of<const double>(array, const_cast<void*>(array.data()), wanted, index);
}

PointArray points_to_write(const py::object& object, const Wanted& wanted, std::span<const Index> index) {
  if (object.is_none()) return {};
  py::array array = take<double>(object, wanted);
  require_writeable(array, wanted);
  return points_of<double>(array, array.mutable_data(), wanted, index);
}

PackedNumbers::PackedNumbers(const py::object& given, const Wanted& wanted) {
  if (given.is_none()) return;
  const auto raw = py::array::ensure(given);
  PyErr_Clear();
  const bool has_numbers = raw && std::string_view("fiub").find(raw.dtype().kind()) != std::string_view::npos;
  const py::object numbers = has_numbers ? py::array_t<double, py::array::c_style | py::array::forcecast>(raw) : given;
  array_ = take<double>(numbers, wanted);
}

std::span<const double> PackedNumbers::span() const {
  return {array_.data(), static_cast<std::size_t>(array_.size())};
}

std::span<double> numbers_to_write(const py::object& object, const Wanted& wanted) {
  if (object.is_none()) return {};
  py::array array = take<double>(object, wanted);
  require_writeable(array, wanted);
  require_packed(array, wanted);
  return {static_cast<double*>(array.mutable_data()), static_cast<std::size_t>(array.size())};
}

std::span<const Index> index_to_read(const py::object& object, const Wanted& wanted) {
  if (object.is_none()) return {};
  const py::array array = take<Index>(object, wanted);
  require_packed(array, wanted);
  return {static_cast<const Index*>(array.data()), static_cast<std::size_t>(array.size())};
}

py::array view(std::span<const double> numbers, py::ssize_t columns, py::handle owner) {
  py::array array(py::dtype::of<double>(), shape_of(numbers, columns), numbers.data(), owner);
  array.attr("flags").attr("writeable") = false;
  return array;
}

py::array copy(std::span<const double> numbers, py::ssize_t columns) {
  return {py::dtype::of<double>(), shape_of(numbers, columns), numbers.data()};
}

}  // namespace tanor::python
