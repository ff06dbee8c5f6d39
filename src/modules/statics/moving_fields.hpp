#pragma once

#include <algorithm>
#include <string>
#include <type_traits>

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

}  // namespace tanor::detail
