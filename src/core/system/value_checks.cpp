#include "system/value_checks.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/text.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

namespace {

bool are_finite(std::span<const double> numbers) {
  return std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); });
}

const char* range_complaint(std::span<const double> numbers) {
  return are_finite(numbers) ? " is out of range: squares must stay finite" : " is not finite";
}

/// Checks one component of a function of time and returns its value. A table that does not reach t is reported with its
/// place.
double check_component(const ScalarFunction& function, double t, const std::string& where, const std::string& noun) {
  Jet<2> jet;
  try {
    jet = function(t);
  } catch (const InputError& error) {
    throw InputError(where, noun + ": " + error.what());
  }
  const std::array jets = {jet.value(), jet.derivative(1), jet.derivative(2)};
  if (is_in_range(jets)) return jet.value();
  if (function.is_constant()) throw InputError(where, noun + " " + text(jet.value()) + range_complaint(jets));
  throw InputError(where, noun + " at t = " + text(t) + " has the value " + text(jets[0]) + " and the derivatives " +
                              text(jets[1]) + " and " + text(jets[2]) +
                              (are_finite(jets) ? "; their squares must stay finite" : "; all must be finite"));
}

void check_scalar_function(const ScalarFunction& function, const ValueRange& range, double t, const std::string& where,
                           const std::string& noun) {
  const double value = check_component(function, t, where, noun);
  check_number(value, range, where, function.is_constant() ? noun : noun + " at t = " + text(t) + ":");
}

}  // namespace

std::string element(const std::string& where, std::size_t index) {
  return where + "/" + text(index);
}

bool is_in_range(double number) {
  return std::abs(number) <= 1e100;  // false for a NaN
}
bool is_in_range(const Vector3& vector) {
  return is_in_range(vector[0]) && is_in_range(vector[1]) && is_in_range(vector[2]);
}

const char* zero_complaint(const Vector3& vector) {
  const Vec3 a = make_vec3(vector);
  if (dot(a, a) > 0.0) return nullptr;
  return vector == Vector3{} ? " is zero" : " is too short: its square is zero";
}

void check_number(double number, const ValueRange& range, const std::string& where, const std::string& noun) {
  if (!is_in_range(number)) throw InputError(where, noun + " " + text(number) + range_complaint({&number, 1}));
  if (const char* complaint = range.complaint(number))
    throw InputError(where, noun + " " + text(number) + " " + complaint);
}

void check_vector(const Vector3& vector, const std::string& where, const std::string& noun) {
  if (!is_in_range(vector)) throw InputError(where, noun + " " + text(vector) + range_complaint(vector));
}

Vector3 check_function(const VectorFunction& function, double t, const std::string& where, const std::string& noun) {
  Vector3 value;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = noun + " " + std::string(1, "xyz"[axis]);
    value[axis] = check_component(function.components[axis], t, where, name);
  }
  return value;
}

void check_nonzero(const Vector3& vector, const std::string& where, const std::string& noun) {
  if (const char* complaint = zero_complaint(vector))
    throw InputError(where, noun + " " + text(vector) + complaint + "; it must have a direction");
}

Vector3 check_direction(const VectorFunction& function, double t, const std::string& where, const std::string& noun) {
  const Vector3 value = check_function(function, t, where, noun);
  if (const char* complaint = zero_complaint(value)) {
    const std::string time = function.is_constant() ? "" : " at t = " + text(t);
    throw InputError(where, noun + " " + text(value) + time + complaint + "; it must have a direction");
  }
  return value;
}

void check_parameter(const Parameter& parameter, std::size_t num_members, const ValueRange& range, double t,
                     const std::string& where, const std::string& noun) {
  const auto& [constants, functions] = parameter;
  if (!constants.empty() && !functions.empty()) {
    throw InputError(where, noun + ": both constants and functions are given; only one of them is right");
  }
  const std::size_t size = constants.size() + functions.size();
  if (size > 1 && size != num_members) {
    throw InputError(where, text_of_count(size, "value") + " for " + text_of_count(num_members, "member") +
                                "; one for all or one for each is right");
  }
  const auto place = [&](std::size_t k) { return size == 1 ? where : element(where, k); };
  for (std::size_t k = 0; k < constants.size(); ++k) {
    // The place is spelled out only for a wrong value, since lists are long.
    if (!is_in_range(constants[k]) || range.complaint(constants[k])) check_number(constants[k], range, place(k), noun);
  }
  for (std::size_t k = 0; k < functions.size(); ++k) check_scalar_function(functions[k], range, t, place(k), noun);
}

}  // namespace tanor::detail
