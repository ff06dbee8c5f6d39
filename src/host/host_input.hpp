#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/text.hpp"

/// \file What a host hands over, checked. Complaints are InputErrors.
namespace tanor {

/// The host's masses and positions as a System; points of infinite mass are supports.
System make_system(std::span<const double> masses, std::vector<Constraint> constraints, const ConstPointArray& at);

template <class Number>
void check_array(const BasicPointArray<Number>& array, std::size_t num_points, std::size_t width, const char* name) {
  if (!array || array.index != nullptr || array.size >= width * num_points) return;
  throw InputError("", std::string(name) + " has " + std::to_string(array.size) + " numbers; " +
                           std::to_string(width * num_points) + " are needed");
}

template <class Number>
void require_array(const BasicPointArray<Number>& array, std::size_t num_points, const char* name) {
  if (!array && num_points > 0) throw InputError("", std::string(name) + " are missing");
  check_array(array, num_points, 3, name);
}

inline void check_number(double number, const char* name) {
  if (!std::isfinite(number)) throw InputError("", std::string(name) + " = " + text(number) + " is not a number");
}

}  // namespace tanor
