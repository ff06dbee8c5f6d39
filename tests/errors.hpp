#pragma once

#include <string>

#include <tanor/error.hpp>

namespace tanor {

/// What an action complains about: "<where>: <what>"; without a place "<what>" alone.
template <class Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return (error.where().empty() ? "" : error.where() + ": ") + error.what();
  }
  return "no error";
}

}  // namespace tanor
