#pragma once

#include <string>
#include <utility>

namespace tanor::detail {

/// Numbers of all processes that have parts of one system. What decides and was found from local arrays goes through
/// these functions, so that every process takes the same branch; all of them must call them, in the same order. This
/// class is a process that is alone: every answer is its own.
class Decisions {
 public:
  /// Returns the largest number of all processes. Among several, a NaN somewhere is infinite everywhere.
  virtual double largest(double own) { return own; }
  virtual double sum(double own) { return own; }
  /// Returns the text of the first process that has one.
  virtual std::string first_text(std::string own) { return own; }
  double smallest(double own) { return -largest(-own); }
  bool any(bool own) { return largest(own ? 1.0 : 0.0) > 0.0; }
  bool all(bool own) { return !any(!own); }

 protected:
  ~Decisions() = default;
};

}  // namespace tanor::detail
