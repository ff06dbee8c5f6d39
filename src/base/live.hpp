#pragma once

#include <string>

#include <tanor/error.hpp>

namespace tanor {

/// What a public object stands on; `name` says which one was moved from where there is nothing.
template <class Pointer>
auto& live(const Pointer& implementation, const char* name) {
  if (implementation == nullptr) {
    throw InputError("", std::string("this ") + name + " was moved from: it can be assigned to or destroyed, no more");
  }
  return *implementation;
}

}  // namespace tanor
