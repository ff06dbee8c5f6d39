#pragma once

#include <any>
#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "python/arrays.hpp"
#include "python/values.hpp"

/// \file
/// A System of C++ as objects of Python. Numbers, words and arrays are Python's own. Functions of time and kernels,
/// which Python cannot take apart, are carried as they are until a System of C++ is read from them again.
namespace tanor::python {

/// A value of C++ that Python carries, and where it stands in which scene: pickle keeps that.
struct Carried {
  std::any value;
  py::object origin = py::none();
};

/// Takes a value that is carried. Returns false if it is one of Python's own.
template <class Value>
bool take_carried(const Given& given, Value* value) {
  if (!py::isinstance<Carried>(given.value)) return false;
  const auto* const found = std::any_cast<Value>(&given.value.cast<const Carried&>().value);
  if (found == nullptr) given.fail("what this field takes");
  *value = *found;
  return true;
}

template <class Value>
inline constexpr bool is_row_of_points = false;
template <std::size_t N>
inline constexpr bool is_row_of_points<std::array<Index, N>> = true;

/// Returns a value as Python sees it.
template <class Value>
py::object give(const Value& value) {
  if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value> || std::is_same_v<Value, std::string> ||
                std::is_same_v<Value, Vector3> || std::is_same_v<Value, std::optional<double>> ||
                std::is_same_v<Value, std::optional<OneSide>>) {
    return default_of(value);
  } else if constexpr (std::is_same_v<Value, std::vector<double>> || std::is_same_v<Value, std::vector<Index>>) {
    return py::array(static_cast<py::ssize_t>(value.size()), value.data());
  } else if constexpr (std::is_same_v<Value, std::vector<Vector3>>) {
    return py::array_t<double>({static_cast<py::ssize_t>(value.size()), py::ssize_t{3}},
                               value.empty() ? nullptr : value.front().data());
  } else if constexpr (requires { requires is_row_of_points<typename Value::value_type>; }) {
    constexpr auto columns = static_cast<py::ssize_t>(std::tuple_size_v<typename Value::value_type>);
    return py::array_t<Index>({static_cast<py::ssize_t>(value.size()), columns},
                              value.empty() ? nullptr : value.front().data());
  } else if constexpr (std::is_same_v<Value, std::vector<std::vector<Index>>> ||
                       std::is_same_v<Value, std::vector<std::string>>) {
    return py::cast(value);
  } else if constexpr (std::is_same_v<Value, ContactOptions>) {
    py::dict limits;
    limits["max_at_one_instant"] = value.max_at_one_instant;
    limits["max_events"] = value.max_events;
    return limits;
  } else if constexpr (std::is_same_v<Value, Parameter>) {
    if (!value.functions.empty()) return py::cast(Carried{value});
    if (value.constants.size() == 1) return py::float_(value.constants[0]);
    return value.is_initial() ? py::object(py::none()) : give(value.constants);
  } else {
    if constexpr (std::is_same_v<Value, VectorFunction>)
      if (value.is_constant()) return default_of(value);
    return py::cast(Carried{value});
  }
}

}  // namespace tanor::python
