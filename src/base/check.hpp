#pragma once

#include <source_location>
#include <stdexcept>
#include <string>

namespace tanor {

/// An invariant of ours is broken: a bug, not a wrong input.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Stops on our own mistake. `thought` says why the condition must hold.
inline void ensure(bool condition, const char* thought, std::source_location here = std::source_location::current()) {
  if (condition) return;
  const std::string path = here.file_name();  // whose folders are the builder's own matter
  throw InternalError(path.substr(path.rfind('/') + 1) + ":" + std::to_string(here.line()) + ": " + thought);
}

}  // namespace tanor
