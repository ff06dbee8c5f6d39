#pragma once

#include <pybind11/numpy.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "python/call.hpp"

/// \file
/// The host's numpy arrays as the library sees them, without copies. A wrong type of numbers is a TypeError. A wrong
/// shape, or a read-only array that is to be written, is a ValueError. The message begins with the argument's name.
namespace tanor::python {

/// The requirements on an argument.
struct Wanted {
  const char* name;
  std::optional<py::ssize_t> rows = {};  ///< none for any number
  py::ssize_t columns = 3;               ///< 0 for a list of numbers, [rows]
};

/// Return float64 [rows, 3] in memory with any distance between rows, or no array for None. The index, int32, says
/// which row is which point; it must outlive the result.
ConstPointArray points_to_read(const py::object& array, const Wanted& wanted, std::span<const Index> index = {});
PointArray points_to_write(const py::object& array, const Wanted& wanted, std::span<const Index> index = {});

/// Packed float64 that are only read: those of the argument itself, or a copy of a list, of other numbers and of arrays
/// with gaps. None has no numbers.
class PackedNumbers {
 public:
  PackedNumbers(const py::object& given, const Wanted& wanted);
  /// Returns the numbers, which live as long as this object.
  std::span<const double> span() const;
  std::vector<double> copy() const { return {span().begin(), span().end()}; }

 private:
  py::array_t<double> array_;
};

/// Returns packed float64, or an empty span for None.
std::span<double> numbers_to_write(const py::object& array, const Wanted& wanted);

/// Returns packed int32 [rows], or an empty span for None.
std::span<const Index> index_to_read(const py::object& array, const Wanted& wanted);

/// Returns a read-only array of Python on numbers that `owner` keeps: [rows, columns], or [rows] if columns is 0.
py::array view(std::span<const double> numbers, py::ssize_t columns, py::handle owner);
/// Returns a copy of numbers as a new array.
py::array copy(std::span<const double> numbers, py::ssize_t columns);

}  // namespace tanor::python
