#pragma once

#include <stdexcept>
#include <string>

namespace tanor {

/// An invariant of ours is broken: a bug, not a wrong input.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Stops on our own mistake. `thought` says why the condition must hold. (std::source_location is unknown to clang 14.)
inline void ensure(bool condition, const char* thought, const char* file = __builtin_FILE(),
                   int line = __builtin_LINE()) {
  if (condition) return;
  const std::string path = file;  // whose folders are the builder's own matter
  throw InternalError(path.substr(path.rfind('/') + 1) + ":" + std::to_string(line) + ": " + thought);
}

}  // namespace tanor
