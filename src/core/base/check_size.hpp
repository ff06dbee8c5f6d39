#pragma once

#include <cstddef>
#include <string>

#include <tanor/error.hpp>

#include "base/text.hpp"

namespace tanor::detail {

/// Throws InputError, "positions has 5 numbers; 6 are needed", if an array of a caller has another size.
inline void check_size(std::size_t found, std::size_t wanted, const std::string& name) {
  if (found == wanted) return;
  throw InputError("", name + " has " + text_of_count(found, "number") + "; " + text(wanted) +
                           (wanted == 1 ? " is needed" : " are needed"));
}

}  // namespace tanor::detail
