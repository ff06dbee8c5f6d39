#pragma once

/// \file Checks of a group's fields by the plain data of its kind. All throw InputError with the JSON pointer of the
/// value; `where` is that of the group.

#include <optional>
#include <string>

#include <tanor/system.hpp>

#include "base/text.hpp"
#include "base/vec3.hpp"
#include "system/members.hpp"
#include "system/value_checks.hpp"

namespace tanor::detail {

/// Throws unless the vector is in range and what its field wants; a direction is not zero.
inline void check_vector_field(const Vector3& vector, const FieldData& data, const std::string& where,
                               const std::string& noun) {
  check_vector(vector, where, noun);
  if (data.role == FieldRole::Direction) check_nonzero(vector, where, noun);
  for (std::size_t axis = 0; axis < 3; ++axis)
    check_number(vector[axis], data.range, where, noun + " " + std::string(1, "xyz"[axis]));
}

/// Throws unless there is no vector, or one vector in range for each member.
template <class Group>
void check_vectors_of_members(const Group& group, const std::vector<Vector3>& vectors, const std::string& where,
                              std::string noun) {
  noun.pop_back();  // turns the plural into the singular
  if (!vectors.empty() && vectors.size() != num_members(group)) {
    throw InputError(where, text_of_count(vectors.size(), noun) + " for " +
                                text_of_count(num_members(group), std::string(KindOf<Group>::name)) +
                                "; one for each is right");
  }
  for (std::size_t k = 0; k < vectors.size(); ++k) {
    if (!is_in_range(vectors[k])) check_vector(vectors[k], element(where, k), noun);
  }
}

/// Checks a field of a known type; a field of another type has checks of its own.
template <class Group, class Value>
void check_field([[maybe_unused]] const Group& group, const FieldOf<Group, Value>& field, double t,
                 const std::string& where_group) {
  const Value& value = group.*field.value;
  const FieldData& data = field.data;
  const std::string where = where_group + "/" + field.name;
  if constexpr (std::is_same_v<Value, Parameter>) {
    for (const ScalarFunction& function : value.functions) {
      if (!data.is_constant || function.is_constant()) continue;
      throw InputError(where, std::string(field.name) + " depends on time; that of a " +
                                  std::string(KindOf<Group>::name) + " is constant");
    }
    check_parameter(value, num_members(group), data.range, t, where, field.name);
    if constexpr (requires { KindOf<Group>::parameter_range; })
      check_parameter(value, num_members(group), KindOf<Group>::parameter_range, t, where, field.name);
  } else if constexpr (std::is_same_v<Value, VectorFunction>) {
    if (data.role == FieldRole::Direction)
      check_direction(value, t, where, field.name);
    else
      check_function(value, t, where, field.name);
  } else if constexpr (std::is_same_v<Value, Vector3>) {
    check_vector_field(value, data, where, field.name);
  } else if constexpr (std::is_same_v<Value, std::array<Vector3, 2>>) {
    for (std::size_t k = 0; k < value.size(); ++k) check_vector_field(value[k], data, element(where, k), "vector");
  } else if constexpr (std::is_same_v<Value, double>) {
    check_number(value, data.range, where, field.name);
  } else if constexpr (std::is_same_v<Value, std::optional<double>>) {
    if (value) check_number(*value, data.range, where, field.name);
  } else if constexpr (std::is_same_v<Value, std::vector<Vector3>>) {
    check_vectors_of_members(group, value, where, field.name);
  } else if constexpr (std::is_same_v<Value, std::vector<double>>) {
    if (data.is_each && !value.empty()) check_parameter(value, num_members(group), data.range, t, where, field.name);
  }
}

template <class Group>
void check_fields(const Group& group, double t, const std::string& where) {
  for_each_field<Group>([&](const auto& field) { check_field(group, field, t, where); });
}

/// Checks that the number of an "initial" parameter at the start is in its range; otherwise calls fail(what is wrong).
template <class Group, class Fail>
void check_initial(double number, const Fail& fail) {
  for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
    if constexpr (std::is_same_v<Value, Parameter>) {
      ValueRange range = field.data.range;
      if constexpr (requires { KindOf<Group>::parameter_range; }) range = KindOf<Group>::parameter_range;
      const char* const complaint = range.complaint(number);
      if (complaint) fail("the initial " + std::string(field.name) + " " + text(number) + " " + complaint);
    }
  });
}

/// Asks the kind what is wrong with a member at the start positions, and calls fail(member, what is wrong).
template <class Group, class Fail>
void check_start(const System& system, const Group& group, double t, const Fail& fail) {
  using Kind = KindOf<Group>;
  const PlacesIn at{system.positions.data()};
  const auto make_now = [&] {
    if constexpr (requires { sizeof(typename Kind::template Definition<double>); })
      return typename Kind::template Definition<double>(group, ClockOf<double>{t});
    else
      return ClockOf<double>{t};
  };
  const auto now = make_now();
  for (std::size_t k = 0; k < num_members(group); ++k) {
    const MemberPlaces r{member_points(group, k), at};
    if constexpr (requires { Kind::complaint(group, now, r, k); }) {
      if (const char* complaint = Kind::complaint(group, now, r, k)) fail(k, complaint);
    }
    if constexpr (requires { now.measure(r, k); }) {
      if ((group.*Kind::parameter).is_initial())
        check_initial<Group>(now.measure(r, k), [&](const std::string& problem) { fail(k, problem); });
    }
  }
}

}  // namespace tanor::detail
