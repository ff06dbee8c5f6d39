#include "system/value_checks.hpp"

#include <algorithm>
#include <cmath>

#include "system/text.hpp"

namespace tanor {

namespace {

/// One component of what depends on time. A table that does not reach t is reported with its place.
double check_component(const ScalarFunction& function, double t, const std::string& where, const std::string& noun) {
  Jet<2> jet;
  try {
    jet = function(t);
  } catch (const InputError& error) {
    throw InputError(where, noun + ": " + error.what());
  }
  if (std::ranges::all_of(jet.c, [](double coefficient) { return std::isfinite(coefficient); })) return jet.value();
  if (function.is_constant()) throw InputError(where, noun + " " + text(jet.value()) + " is not finite");
  throw InputError(where, noun + " at t = " + text(t) + " has the value " + text(jet.value()) +
                              " and the derivatives " + text(jet.derivative(1)) + " and " + text(jet.derivative(2)) +
                              "; all must be finite");
}

void check_scalar_function(const ScalarFunction& function, const Rule& rule, double t, const std::string& where,
                           const std::string& noun) {
  const double value = check_component(function, t, where, noun);
  check_number(value, rule, where, function.is_constant() ? noun : noun + " at t = " + text(t) + ":");
}

}  // namespace

std::string element(const std::string& where, std::size_t index) {
  return where + "/" + text(index);
}

bool is_finite(const Vector3& vector) {
  return std::isfinite(vector[0]) && std::isfinite(vector[1]) && std::isfinite(vector[2]);
}

void check_number(double number, const Rule& rule, const std::string& where, const std::string& noun) {
  if (!std::isfinite(number)) throw InputError(where, noun + " " + text(number) + " is not finite");
  if (!rule.holds(number)) throw InputError(where, noun + " " + text(number) + " " + rule.complaint);
}

void check_vector(const Vector3& vector, const std::string& where, const std::string& noun) {
  if (!is_finite(vector)) throw InputError(where, noun + " " + text(vector) + " is not finite");
}

Vector3 check_function(const VectorFunction& function, double t, const std::string& where, const std::string& noun) {
  Vector3 value;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = noun + " " + std::string(1, "xyz"[axis]);
    value[axis] = check_component(function.components[axis], t, where, name);
  }
  return value;
}

Vector3 check_direction(const VectorFunction& function, double t, const std::string& where, const std::string& noun) {
  const Vector3 value = check_function(function, t, where, noun);
  if (value == Vector3{}) {
    const std::string time = function.is_constant() ? "" : " at t = " + text(t);
    throw InputError(where, noun + " " + text(value) + time + " is zero; it must have a direction");
  }
  return value;
}

void check_parameter(const Parameter& parameter, std::size_t num_members, const Rule& rule, double t,
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
    // The place is spelled out only for a wrong value: lists are long.
    if (!std::isfinite(constants[k]) || !rule.holds(constants[k])) check_number(constants[k], rule, place(k), noun);
  }
  for (std::size_t k = 0; k < functions.size(); ++k) check_scalar_function(functions[k], rule, t, place(k), noun);
}

}  // namespace tanor
