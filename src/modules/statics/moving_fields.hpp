#pragma once

#include <algorithm>
#include <string>
#include <type_traits>
#include <variant>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns false for functions of time that are not constant.
template <class Value>
bool is_constant_field(const Value& value) {
  if constexpr (std::is_same_v<Value, VectorFunction>) return value.is_constant();
  if constexpr (std::is_same_v<Value, Parameter>)
    return std::ranges::all_of(value.functions, &ScalarFunction::is_constant);
  return true;
}

/// Returns "normal, offset", the fields of a group that depend on time, or "formula".
template <class Group>
std::string name_moving_fields(const Group& group) {
  std::string names;
  const auto add = [&](const char* name) { names += (names.empty() ? "" : ", ") + std::string(name); };
  for_each_field<Group>([&](const auto& field) {
    if (!is_constant_field(group.*field.value)) add(field.name);
  });
  if constexpr (requires { group.kernel.depends_on_time; }) {
    if (group.kernel.depends_on_time) add("formula");
  }
  return names;
}
inline std::string name_moving_fields(const Support& support) {
  return support.displacement.is_constant() ? "" : "motion";
}

/// Calls visit(where, name, part) for each support, each group of constraints and each force of a system.
template <class Visit>
void for_each_part(const System& system, const Visit& visit) {
  for (std::size_t k = 0; k < system.supports.size(); ++k) {
    const Support& support = system.supports[k];
    const std::string number = std::to_string(k);
    visit("/supports/" + number, support.name.empty() ? "support" + number : support.name, support);
  }
  const auto visit_list = [&](const char* list, const auto& entries, const auto& name_of) {
    for (std::size_t k = 0; k < entries.size(); ++k)
      std::visit([&](const auto& each) { visit(list + std::to_string(k), name_of(system, k), each); }, entries[k]);
  };
  visit_list("/constraints/", system.constraints, constraint_name);
  visit_list("/forces/", system.forces, force_name);
}

}  // namespace tanor::detail
