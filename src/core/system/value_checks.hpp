#pragma once

/// \file Checks of single values of a system: numbers, vectors, parameters, functions of time.
///
/// All throw InputError with the JSON pointer `where`; `noun` says what the value is ("length").

#include <string>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns the JSON pointer of an element of the list at `where`.
std::string element(const std::string& where, std::size_t index);

/// True if the number is finite and at most 1e100 in magnitude, so that squares stay finite, and sums of many.
bool is_in_range(double number);
bool is_in_range(const Vector3& vector);

/// Returns what to say about a vector that is zero or has a square of zero, else null.
const char* zero_complaint(const Vector3& vector);

/// Throws unless the number is finite, at most 1e100 in magnitude, and in its range.
void check_number(double number, const ValueRange& range, const std::string& where, const std::string& noun);

/// Throws unless all components are in range.
void check_vector(const Vector3& vector, const std::string& where, const std::string& noun);

/// Throws unless value and two derivatives at t are in range. Returns the value.
Vector3 check_function(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// Throws if a constant normal or direction is zero.
void check_nonzero(const Vector3& vector, const std::string& where, const std::string& noun);
/// Does the same for one that may depend on time. Returns its value.
Vector3 check_direction(const VectorFunction& function, double t, const std::string& where, const std::string& noun);

/// Throws unless the parameter is "initial", one value for all or one for each of the `num_members`, with values in
/// range at t.
void check_parameter(const Parameter& parameter, std::size_t num_members, const ValueRange& range, double t,
                     const std::string& where, const std::string& noun);

}  // namespace tanor::detail
