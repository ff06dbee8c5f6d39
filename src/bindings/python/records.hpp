#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <tanor/enum_names.hpp>
#include <tanor/motion.hpp>
#include <tanor/report_fields.hpp>

#include "base/member_names.hpp"
#include "python/arrays.hpp"
#include "python/header_docs.hpp"
#include "python/kinds.hpp"

/// \file
/// Reports as small objects of Python. Their members are read-only attributes with the headers' own comments, and a
/// repr shows them all.
namespace tanor::python {
using namespace detail;

/// True for lists of words, which Python sees as one text, "batches+general".
template <class Value>
inline constexpr bool is_list_of_words = false;
template <class Word>
inline constexpr bool is_list_of_words<std::vector<Word>> = std::is_enum_v<Word>;
template <class Value>
concept ListOfValues = requires {
  typename Value::value_type;
}
&&!std::is_same_v<Value, std::string>;

/// Returns a member as Python sees it. `columns` are those of an array of numbers, and `owner` owns its memory.
template <class Value>
py::object value_of(const Value& value, py::ssize_t columns, const py::object& owner) {
  if constexpr (std::is_enum_v<Value>) {
    return py::str(std::string(name_of(value)));
  } else if constexpr (std::is_same_v<Value, std::size_t>) {
    return value == std::numeric_limits<std::size_t>::max() ? py::object(py::none()) : py::object(py::int_(value));
  } else if constexpr (std::is_convertible_v<Value, std::span<const double>>) {
    return view(value, columns, owner);
  } else if constexpr (is_list_of_words<Value>) {
    return py::str(names_of(value));
  } else if constexpr (ListOfValues<Value>) {
    py::list list;
    for (const auto& each : value) list.append(value_of(each, 0, owner));
    return list;
  } else if constexpr (std::is_class_v<Value> && !std::is_same_v<Value, std::string>) {
    py::object record = py::cast(value, py::return_value_policy::reference_internal, owner);
    if (!record) throw py::error_already_set();
    return record;
  } else {
    return py::cast(value);
  }
}

/// Returns the type of a member as the stubs write it.
template <class Value>
std::string type_in_stub() {
  if constexpr (std::is_same_v<Value, bool>)
    return "bool";
  else if constexpr (std::is_integral_v<Value>)
    return "int";
  else if constexpr (std::is_same_v<Value, double>)
    return "float";
  else if constexpr (std::is_enum_v<Value> || std::is_same_v<Value, std::string> || is_list_of_words<Value>)
    return "str";
  else if constexpr (std::is_convertible_v<Value, std::span<const double>>)
    return "numpy.ndarray";
  else if constexpr (ListOfValues<Value>)
    return "list";
  else
    return py::type::of<Value>().attr("__name__").template cast<std::string>();
}

/// The class of a report, with its members under their own names:
/// `Record<Outcome>(module).fields<&Outcome::status, &Outcome::what>()`. One with an outcome has "ok", too.
template <class Report>
class Record {
 public:
  /// Makes the class. `otherwise` is its docstring if the header says nothing of the whole.
  explicit Record(py::module_& module, const char* otherwise = "")
      : name_(name_of_struct<Report>()),
        type_(module, name_.c_str(), (header_doc(name_) + otherwise).c_str(), py::module_local(), py::dynamic_attr()) {
    type_.attr("_fields") = fields_;
    for (const auto& [name, function] : {std::pair("__repr__", "short_repr"), std::pair("__reduce__", "reduce_report")})
      type_.def(name, [function = function](const py::object& self) {
        return py::module_::import("tanor.description").attr(function)(self);
      });
    if constexpr (requires(Report report) { report.outcome.ok(); }) {
      property(
          "ok", [](const Report& self) { return self.outcome.ok(); }, "bool");
    }
  }

  /// Adds members, of a base too, with the headers' comments.
  template <auto... members>
  Record& fields() {
    return (add<members>(own_name<members>(), name_in_header<members>(), 0), ..., *this);
  }
  /// Adds arrays of points, [n, 3].
  template <auto... members>
  Record& points() {
    return (add<members>(own_name<members>(), name_in_header<members>(), 3), ..., *this);
  }
  /// Adds members of a part of the report, which stand among the others in Python. `prefix` and `suffix` surround their
  /// names.
  template <auto part, auto... members>
  Record& parts(const std::string& prefix = "", const std::string& suffix = "", py::ssize_t columns = 0) {
    return (add<part, members>(prefix + own_name<members>() + suffix, name_in_header<members>(), columns), ..., *this);
  }
  /// Adds all fields of the table of a part of the report, which stand among the others in Python.
  template <auto part>
  Record& table_of_part() {
    using Part = std::remove_cvref_t<decltype(std::declval<const Report&>().*part)>;
    fields_of<Part>.for_each([this]<auto member, ReportKey key, int columns>(ReportField<member, key, columns>) {
      add<part, member>(own_name<member>(), name_in_header<member>(), columns);
    });
    return *this;
  }
  /// Adds all fields of the report's table.
  Record& table() requires HasReportFields<Report> {
    fields_of<Report>.for_each([this]<auto member, ReportKey key, int columns>(ReportField<member, key, columns>) {
      if constexpr (std::is_member_object_pointer_v<decltype(member)>)
        add<member>(own_name<member>(), name_in_header<member>(), columns);
      else
        property(own_name<member>(), member, type_in_stub<std::invoke_result_t<decltype(member), const Report&>>(),
                 name_in_header<member>());
    });
    return *this;
  }
  /// Adds a member that is no plain field, with its `type` as the stubs write it.
  template <class Get>
  Record& property(const std::string& name, const Get& get, const std::string& type) {
    return property(name, get, type, name_ + "." + name);
  }

  /// Adds a value that is stored with the report, or a function of the report that finds it when it is asked for. It
  /// is None in a report without it.
  Record& kept(const std::string& name, const std::string& type, const std::string& text) {
    const auto get = [name](const py::object& self) {
      const py::dict all = self.attr("__dict__");
      py::object value = all.attr("get")(name);
      if (py::isinstance<py::function>(value)) all[py::str(name)] = value = value(self);
      return value;
    };
    type_.def_property_readonly(name.c_str(), get, ("(" + type + ") " + text).c_str());
    return *this;
  }

 private:
  template <auto member>
  static std::string own_name() {
    return std::string(name_of_member<member>());
  }
  template <auto member>
  static std::string name_in_header() {
    const auto name_of_owner = []<class Struct, class Value>(Value Struct::*) { return name_of_struct<Struct>(); };
    return std::string(name_of_owner(member)) + "." + own_name<member>();
  }
  /// Adds what a path of members leads to.
  template <auto... path>
  Record& add(const std::string& name, const std::string& where, py::ssize_t columns) {
    using Value = std::remove_cvref_t<decltype((std::declval<const Report&>().*....*path))>;
    return property(
        name,
        [columns](const py::object& self) { return value_of((self.cast<const Report&>().*....*path), columns, self); },
        type_in_stub<Value>(), where);
  }
  /// Adds a property. `where` is what the headers' comment belongs to.
  template <class Get>
  Record& property(const std::string& name, const Get& get, const std::string& type, const std::string& where) {
    const std::string said = header_doc(where);
    type_.def_property_readonly(name.c_str(), get, ("(" + type + ") " + (said.empty() ? name : said)).c_str());
    fields_.append(name);
    return *this;
  }

  std::string name_;
  py::class_<Report> type_;
  py::list fields_;
};

inline constexpr const char* groups_doc =
    "first equation, members and equations a member of each group of constraints, by name; springs and bonds have none";
inline constexpr const char* tensions_doc =
    "float64 [members], N, of each group of rods, ropes, springs and bonds, by name";

/// Returns a report as an object of Python with the system of which it speaks, its groups and their tensions.
template <class Report>
py::object keep(Report&& report, const py::object& system_as_given, const System& system,
                const std::vector<Observed>& tensions) {
  py::object result = py::cast(std::forward<Report>(report));
  result.attr("__dict__")["system"] = system_as_given;
  result.attr("__dict__")["groups"] = list_groups(system);
  result.attr("__dict__")["tensions"] = tensions_from(tensions);
  return result;
}

}  // namespace tanor::python
