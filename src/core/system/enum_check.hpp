#pragma once

#include <string>

#include <tanor/error.hpp>

namespace tanor::detail {

/// Throws InputError if a host's value is none of the enumeration's, which count from 0 to `last`.
template <class Enum>
void check_enum(Enum value, Enum last, const char* where) {
  const auto number = static_cast<long>(value);
  if (number >= 0 && number <= static_cast<long>(last)) return;
  throw InputError(where, std::to_string(number) + " is no value of this enumeration; 0 to " +
                              std::to_string(static_cast<long>(last)) + " are");
}

}  // namespace tanor::detail
