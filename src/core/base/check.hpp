#pragma once

#include <stdexcept>
#include <string>

namespace tanor::detail {

/// Thrown if one of our own invariants is broken. This is a bug, not a wrong input.
class InternalError : public std::logic_error {
 public:
  using std::logic_error::logic_error;
};

/// Throws InternalError if one of our own invariants is broken. `thought` says why the condition must hold. (clang 14
/// has no std::source_location.)
inline void ensure(bool condition, const char* thought, const char* file = __builtin_FILE(),
                   int line = __builtin_LINE()) {
  if (condition) return;
  const std::string path = file;  // with the folders of the build machine
  throw InternalError(path.substr(path.rfind('/') + 1) + ":" + std::to_string(line) + ": " + thought);
}

}  // namespace tanor::detail
