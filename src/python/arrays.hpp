#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>

#include <tanor/constrainer.hpp>

#include "python/call.hpp"

/// \file
/// The host's numpy arrays as the library sees them: nothing is copied. A wrong type of numbers is a TypeError, a wrong
/// shape or a read-only array that is to be written a ValueError; the message begins with the argument's name.
namespace tanor::python {

/// An argument has to be this.
struct Wanted {
  const char* name;
  std::optional<py::ssize_t> rows = {};  ///< none: any number
  py::ssize_t columns = 3;               ///< 0: a list of numbers, [rows]
};

/// float64 [rows, 3] in memory of any distance between rows; None: no array. The index, int32, says which row is which
/// point; it must outlive the result.
ConstPointArray points_to_read(const py::object& array, const Wanted& wanted, std::span<const Index> index = {});
PointArray points_to_write(const py::object& array, const Wanted& wanted, std::span<const Index> index = {});

/// Packed float64; None: an empty span.
std::span<const double> numbers_to_read(const py::object& array, const Wanted& wanted);
std::span<double> numbers_to_write(const py::object& array, const Wanted& wanted);

/// int32 [rows], packed; None: an empty span.
std::span<const Index> index_to_read(const py::object& array, const Wanted& wanted);

/// An array of Python's on numbers that `owner` keeps; [rows, columns], or [rows] where columns is 0. Read-only.
py::array view(std::span<const double> numbers, py::ssize_t columns, py::handle owner);
/// A copy of numbers as a new array.
py::array copy(std::span<const double> numbers, py::ssize_t columns);

}  // namespace tanor::python
