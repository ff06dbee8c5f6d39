#pragma once

/// \file Checks of single values of a system: numbers, vectors, parameters, functions of time.
///
/// All throw InputError with the JSON pointer `where`; `noun` says what the value is ("length").

#include <cmath>
#include <limits>
#include <string>

#include <tanor/system.hpp>

namespace tanor {

/// What a number must be beyond finite, and what is said when it is not.
struct Rule {
  bool (*holds)(double);
  const char* complaint;

  static const Rule any, positive, not_negative, not_zero, cosine, not_straight;
};

inline constexpr Rule Rule::any = {[](double) { return true; }, ""};
inline constexpr Rule Rule::positive = {[](double x) { return x > 0.0; }, "is not positive"};
inline constexpr Rule Rule::not_negative = {[](double x) { return x >= 0.0; }, "is negative"};
inline constexpr Rule Rule::not_zero = {[](double x) { return x != 0.0; }, "must not be zero"};
inline constexpr Rule Rule::cosine = {[](double x) { return -1.0 <= x && x <= 1.0; }, "is not between -1 and 1"};

// To rounding. The cosine has no slope there: the constraint would have no gradient.
inline constexpr Rule Rule::not_straight = {
    [](double x) { return std::abs(x) < 1.0 - 8.0 * std::numeric_limits<double>::epsilon(); },
    "is that of a straight triple, whose angle cannot be held by its cosine; use a line or rods"};

/// JSON pointer of an element of the list at `where`.
std::string element(const std::string& where, std::size_t index);

/// Finite and at most 1e100 in magnitude: squares stay finite, and sums of many.
bool is_in_range(double number);
bool is_in_range(const Vector3& vector);

/// What to say about a vector that is zero or has a square of zero; else null.
const char* zero_complaint(const Vector3& vector);

/// In range, and as the rule says.
void check_number(double number, const Rule& rule, const std::string& where, const std::string& noun);

/// All components in range.
void check_vector(const Vector3& vector, const std::string& where, const std::string& noun);

/// Value and two derivatives at t are in range; returns the value.
Vector3 check_function(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// The same for a normal or a direction, which must not be zero.
Vector3 check_direction(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// "initial", one value for all or one for each of the `num_members`; values as the rule says, at t.
void check_parameter(const Parameter& parameter, std::size_t num_members, const Rule& rule, double t,
                     const std::string& where, const std::string& noun);

}  // namespace tanor
