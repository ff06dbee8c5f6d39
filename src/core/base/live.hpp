#pragma once

#include <string>

#include <tanor/error.hpp>

namespace tanor::detail {

/// Returns the implementation that a public object points to. Throws InputError with the object's `name` if the object
/// was moved from.
template <class Pointer>
auto& live(const Pointer& implementation, const char* name) {
  if (implementation == nullptr) {
    throw InputError("", std::string("this ") + name + " was moved from: it can be assigned to or destroyed, no more");
  }
  return *implementation;
}

}  // namespace tanor::detail
