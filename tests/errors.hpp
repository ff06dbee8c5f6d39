#pragma once

#include <string>

#include <tanor/error.hpp>

namespace tanor {

/// Returns what an action complains about, as "<where>: <what>", or as "<what>" if there is no place.
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
