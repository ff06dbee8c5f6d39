#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include <tanor/enum_names.hpp>
#include <tanor/motion.hpp>
#include <tanor/report_fields.hpp>

#include "python/arrays.hpp"
#include "python/header_docs.hpp"

/// \file
/// Reports as small objects of Python. Their members are read-only attributes with the headers' own comments, and a
/// repr shows them all.
namespace tanor::python {

/// True if a report's outcome is ok.
template <class Report>
bool is_ok(const Report& report) {
  return report.outcome.ok();
}

/// Returns a member as Python sees it. `columns` are those of an array of numbers, and `owner` owns its memory.
template <class Value>
py::object value_of(const Value& value, py::ssize_t columns, const py::object& owner) {
  if constexpr (std::is_same_v<Value, Method>) {
    return py::str(std::string(name_of(value)));
  } else if constexpr (std::is_same_v<Value, Status>) {
    return py::str(std::string(name_of(value)));
  } else if constexpr (std::is_enum_v<Value>) {
    return py::str(std::string(name_of(value)));
  } else if constexpr (std::is_same_v<Value, std::size_t>) {
    return value == std::numeric_limits<std::size_t>::max() ? py::object(py::none()) : py::object(py::int_(value));
  } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
    return view(value, columns, owner);
  } else if constexpr (std::is_same_v<Value, std::array<double, 6>>) {
    return view(value, 0, owner);
  } else if constexpr (std::is_same_v<Value, std::vector<LinearSolver>> ||
                       std::is_same_v<Value, std::vector<Ordering>> ||
                       std::is_same_v<Value, std::vector<Factorization>>) {
    return py::str(names_of(value));
  } else if constexpr (requires { typename Value::value_type; } && !std::is_same_v<Value, std::string>) {
    py::list list;
    for (const auto& each : value) list.append(value_of(each, 0, owner));
    return list;
  } else if constexpr (std::is_class_v<Value> && !std::is_same_v<Value, std::string>) {
    return py::cast(value, py::return_value_policy::reference_internal, owner);
  } else {
    return py::cast(value);
  }
}

/// The class of a report: `Record<Outcome>(module, "Outcome").field("what", &Outcome::what)`.
template <class Report>
class Record {
 public:
  /// Makes the class. `otherwise` is its docstring if the header says nothing of the whole.
  Record(py::module_& module, const char* name, const char* otherwise = "")
      : name_(name), type_(module, name, (header_doc(name) + otherwise).c_str(), py::module_local()) {
    type_.attr("_fields") = fields_;
    type_.def("__repr__", [](const py::object& self) {
      std::string text = py::type::of(self).attr("__name__").template cast<std::string>() + "(";
      bool is_first = true;
      for (const py::handle field : self.attr("_fields")) {
        text += (is_first ? "" : ", ") + field.cast<std::string>() + "=" +
                py::repr(self.attr(field)).template cast<std::string>();
        is_first = false;
      }
      return text + ")";
    });
  }

  template <class Value>
  Record& field(const char* name, Value Report::*member, py::ssize_t columns = 0) {
    return field(name, name_ + "." + name, member, columns);
  }
  /// Adds all fields of the report's table.
  Record& fields() requires HasReportFields<Report> {
    std::apply([&](const auto&... each) { (field(each.key, each.value), ...); }, FieldsOf<Report>::fields);
    return *this;
  }
  /// Adds a member of a base of the report. Its comment is that of `where`, such as "EventReport.events".
  template <class Base, class Value>
  requires std::derived_from<Report, Base> Record& field(const char* name, const std::string& where,
                                                         Value Base::*member, py::ssize_t columns = 0) {
    return property(
        name,
        [member, columns](const py::object& self) {
          return value_of(self.cast<const Report&>().*member, columns, self);
        },
        in_stub<Value>(), where);
  }
  /// Adds a member of a part of the report, which stands among the others in Python. Its comment is that of `where`,
  /// such as "Violations.position".
  template <class Part, class Value>
  Record& field(const char* name, const char* where, Part Report::*part, Value Part::*member, py::ssize_t columns = 0) {
    return property(
        name,
        [part, member, columns](const py::object& self) {
          return value_of(self.cast<const Report&>().*part.*member, columns, self);
        },
        in_stub<Value>(), where);
  }
  /// Adds a member that is no plain field, with its `type` as the stubs write it.
  template <class Get>
  Record& property(const char* name, const Get& get, const std::string& type) {
    return property(name, get, type, name_ + "." + name);
  }

  template <class Call, class... Arguments>
  Record& method(const char* name, const Call& call, const char* text, const Arguments&... arguments) {
    type_.def(name, call, text, arguments...);
    return *this;
  }

 private:
  /// Adds a property. `where` is what the headers' comment belongs to.
  template <class Get>
  Record& property(const char* name, const Get& get, const std::string& type, const std::string& where) {
    const std::string said = header_doc(where);
    type_.def_property_readonly(name, get, ("(" + type + ") " + (said.empty() ? name : said)).c_str());
    fields_.append(name);
    return *this;
  }

  template <class Value>
  static std::string in_stub() {
    if constexpr (std::is_same_v<Value, bool>)
      return "bool";
    else if constexpr (std::is_same_v<Value, int> || std::is_same_v<Value, Index>)
      return "int";
    else if constexpr (std::is_same_v<Value, std::size_t>)
      return "int";
    else if constexpr (std::is_same_v<Value, double>)
      return "float";
    else if constexpr (std::is_enum_v<Value> || std::is_same_v<Value, std::string>)
      return "str";
    else if constexpr (std::is_same_v<Value, std::vector<double>> || std::is_same_v<Value, std::array<double, 6>>)
      return "numpy.ndarray";
    else if constexpr (std::is_same_v<Value, std::vector<LinearSolver>> ||
                       std::is_same_v<Value, std::vector<Ordering>> ||
                       std::is_same_v<Value, std::vector<Factorization>>)
      return "str";
    else if constexpr (requires { typename Value::value_type; } && !std::is_same_v<Value, std::string>)
      return "list";
    else if constexpr (std::is_class_v<Value>)
      return py::type::of<Value>().attr("__name__").template cast<std::string>();
    else
      return "object";
  }

  std::string name_;
  py::class_<Report> type_;
  py::list fields_;
};

}  // namespace tanor::python
