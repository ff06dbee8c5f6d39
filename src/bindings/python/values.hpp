#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <type_traits>
#include <vector>

#include <tanor/modes.hpp>
#include <tanor/motion.hpp>
#include <tanor/statics_names.hpp>
#include <tanor/system.hpp>

#include "base/suggestion.hpp"
#include "python/call.hpp"

/// \file
/// Conversion of values of a description, both ways: what a field of a C++ struct is made of, and its default in
/// Python. A value that cannot be read is an InputError that says where, what was found and what is wanted.
namespace tanor::python {

/// A value of Python and its place in the description, as the library's own messages name it.
struct Given {
  py::object value;
  std::string place;  ///< a JSON pointer: "/constraints/2/length"

  /// Throws InputError.
  [[noreturn]] void fail(const std::string& wanted) const;
  /// Returns an attribute of the value.
  Given operator[](const char* name) const;
  /// Returns the entries of a sequence.
  std::vector<Given> entries(const char* wanted) const;
};

void read(const Given& given, bool* flag);
void read(const Given& given, int* number);         // Index, too
void read(const Given& given, std::size_t* count);  // "all" is the largest number
void read(const Given& given, double* number);
void read(const Given& given, std::optional<double>* number);
void read(const Given& given, std::string* text);
void read(const Given& given, Vector3* vector);
void read(const Given& given, std::array<Vector3, 2>* vectors);
void read(const Given& given, ScalarFunction* function);
void read(const Given& given, VectorFunction* function);
void read(const Given& given, Parameter* parameter);
void read(const Given& given, Method* method);
void read(const Given& given, std::vector<std::string>* names);
void read(const Given& given, std::vector<double>* numbers);
void read(const Given& given, std::vector<Vector3>* vectors);
void read(const Given& given, std::vector<std::int64_t>* numbers);
void read(const Given& given, std::vector<Index>* points);
template <std::size_t N>
void read(const Given& given, std::vector<std::array<Index, N>>* tuples);  // pairs, triples, quadruples
void read(const Given& given, std::vector<std::vector<Index>>* tuples);
void read(const Given& given, std::vector<std::vector<double>>* constants);  // a dict of names
void read(const Given& given, std::vector<Prestress>* prestress);            // likewise a dict
void read(const Given& given, std::vector<OneSided>* sides);                 // likewise a dict
void read(const Given& given, ContactOptions* contact);                      // likewise a dict

/// Returns the words of an enumeration, "auto, normal, tangent".
template <class Enum>
std::string words_of() {
  std::string words;
  for (const auto& each : enum_names<Enum>) words += (words.empty() ? "" : ", ") + std::string(each.name);
  return words;
}

template <class Enum>
requires std::is_enum_v<Enum>
void read(const Given& given, Enum* value) {
  std::string word;
  read(given, &word);
  const std::optional<Enum> found = tanor::value_of<Enum>(word);
  if (!found) {
    std::vector<std::string> known;
    for (const auto& each : enum_names<Enum>) known.emplace_back(each.name);
    given.fail("one of " + words_of<Enum>() + detail::suggest(word, known));
  }
  *value = *found;
}

template <class Enum>
requires std::is_enum_v<Enum>
void read(const Given& given, std::optional<Enum>* value) {
  if (given.value.is_none()) return value->reset();
  read(given, &value->emplace());
}

/// Returns the default of a field as Python's code writes it: "None", "(0.0, 0.0, 0.0)".
template <class Value>
py::object default_of(const Value& value) {
  if constexpr (std::is_enum_v<Value>) {
    return py::str(std::string(name_of(value)));
  } else if constexpr (std::is_same_v<Value, std::optional<OneSide>>) {
    return value ? default_of(*value) : py::object(py::none());
  } else if constexpr (std::is_same_v<Value, std::size_t>) {
    return value == std::numeric_limits<std::size_t>::max() ? py::object(py::str("all")) : py::object(py::int_(value));
  } else if constexpr (std::is_same_v<Value, Vector3>) {
    return py::make_tuple(value[0], value[1], value[2]);
  } else if constexpr (std::is_same_v<Value, std::array<Vector3, 2>>) {
    return py::make_tuple(default_of(value[0]), default_of(value[1]));
  } else if constexpr (std::is_same_v<Value, VectorFunction>) {
    const auto at = value(0.0);
    return py::make_tuple(at[0].value(), at[1].value(), at[2].value());
  } else if constexpr (std::is_same_v<Value, Parameter>) {
    return value.is_initial() ? py::object(py::none()) : py::cast(value.constants.at(0));
  } else if constexpr ((std::ranges::range<Value> && !std::is_same_v<Value, std::string>) ||
                       std::is_same_v<Value, ContactOptions>) {
    return py::tuple();
  } else {
    return py::cast(value);
  }
}

/// The values that a field of this type takes, in words for docstrings, and its type in the stubs.
struct TypeInWords {
  const char* annotation;
  const char* shape;
};
template <class Value>
constexpr TypeInWords in_words() {
  if constexpr (std::is_same_v<Value, bool>) return {"bool", "true or false"};
  if constexpr (std::is_same_v<Value, int>) return {"int", "a whole number"};
  if constexpr (std::is_same_v<Value, std::size_t>) return {"int | str", "a whole number or \"all\""};
  if constexpr (std::is_same_v<Value, double>) return {"float", "a number"};
  if constexpr (std::is_same_v<Value, std::optional<double>>) return {"float | None", "a number or None"};
  if constexpr (std::is_same_v<Value, std::optional<OneSide>>)
    return {"str | None", "\"at_least\" or \"at_most\", or None: both sides"};
  if constexpr (std::is_same_v<Value, std::string>) return {"str", "a text"};
  if constexpr (std::is_same_v<Value, Vector3>) return {"ArrayLike", "float [3]"};
  if constexpr (std::is_same_v<Value, std::array<Vector3, 2>>) return {"ArrayLike", "float [2, 3]"};
  if constexpr (std::is_same_v<Value, VectorFunction>)
    return {"VectorLike", "float [3], three functions of time, or one callable of time"};
  if constexpr (std::is_same_v<Value, Parameter>)
    return {"ParameterLike", "None (as at the start), a number or function of time for all, or one for each"};
  if constexpr (std::is_same_v<Value, std::vector<std::string>>) return {"str | Sequence[str]", "names"};
  if constexpr (std::is_same_v<Value, std::vector<double>>) return {"ArrayLike", "float [n]"};
  if constexpr (std::is_same_v<Value, std::vector<Vector3>>) return {"ArrayLike", "float [n, 3]"};
  if constexpr (std::is_same_v<Value, std::vector<Index>>) return {"ArrayLike", "int [n]"};
  if constexpr (std::is_same_v<Value, std::vector<std::array<Index, 2>>>) return {"ArrayLike", "int [n, 2]"};
  if constexpr (std::is_same_v<Value, std::vector<std::array<Index, 3>>>) return {"ArrayLike", "int [n, 3]"};
  if constexpr (std::is_same_v<Value, std::vector<std::array<Index, 4>>>) return {"ArrayLike", "int [n, 4]"};
  if constexpr (std::is_same_v<Value, std::vector<std::vector<double>>>)
    return {"dict[str, ArrayLike]", "names, each with a number for all tuples or one for each"};
  if constexpr (std::is_same_v<Value, std::vector<Prestress>>)
    return {"dict[str, ArrayLike]", "names of rods, each with a number for all or one for each"};
  if constexpr (std::is_same_v<Value, std::vector<OneSided>>)
    return {"dict[str, str]", "names of constraints, each with \"at_least\" or \"at_most\""};
  if constexpr (std::is_same_v<Value, ContactOptions>)
    return {"dict[str, int]", "\"max_at_one_instant\" and \"max_events\", each with a whole number"};
  if constexpr (std::is_same_v<Value, std::vector<std::vector<Index>>>) return {"ArrayLike", "int [n, p]"};
  if constexpr (std::is_enum_v<Value>) return {"str", "a word"};
  return {"Any", ""};
}

}  // namespace tanor::python
