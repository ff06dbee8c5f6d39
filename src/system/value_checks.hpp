#pragma once

/// \file Checks of single values of a system: numbers, vectors, parameters, functions of time.
///
/// All throw InputError with the JSON pointer `where`; `noun` says what the value is ("length").

#include <string>

#include <tanor/system.hpp>

namespace tanor {

/// What a number must be beyond finite, and what is said when it is not.
struct Rule {
  bool (*holds)(double);
  const char* complaint;

  static const Rule any, positive, not_negative, not_zero, cosine;
};

inline constexpr Rule Rule::any = {[](double) { return true; }, ""};
inline constexpr Rule Rule::positive = {[](double x) { return x > 0.0; }, "is not positive"};
inline constexpr Rule Rule::not_negative = {[](double x) { return x >= 0.0; }, "is negative"};
inline constexpr Rule Rule::not_zero = {[](double x) { return x != 0.0; }, "must not be zero"};
inline constexpr Rule Rule::cosine = {[](double x) { return -1.0 <= x && x <= 1.0; }, "is not between -1 and 1"};

/// JSON pointer of an element of the list at `where`.
std::string element(const std::string& where, std::size_t index);

bool is_finite(const Vector3& vector);

void check_number(double number, const Rule& rule, const std::string& where, const std::string& noun);

/// All components finite.
void check_vector(const Vector3& vector, const std::string& where, const std::string& noun);

/// Value and two derivatives at t are finite; returns the value.
Vector3 check_function(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// The same for a normal or a direction, which must not be zero.
Vector3 check_direction(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// "initial", one value for all or one for each of the `num_members`; values as the rule says, at t.
void check_parameter(const Parameter& parameter, std::size_t num_members, const Rule& rule, double t,
                     const std::string& where, const std::string& noun);

}  // namespace tanor
