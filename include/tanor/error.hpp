#pragma once

#include <stdexcept>
#include <string>

#include <tanor/export.hpp>

namespace tanor {

/// Wrong input of the caller. The message says what is wrong, with its value and the rule that it breaks. `where()` is
/// a JSON pointer into the scene (`/constraints/3/pairs/17`), empty if there is no such place.
class TANOR_API InputError : public std::runtime_error {
 public:
  InputError(std::string where, const std::string& what);
  ~InputError() override;
  const std::string& where() const { return where_; }

 private:
  std::string where_;
};

/// Status of a computation. A numerical outcome is an answer, not an exception.
enum class Status {
  Ok,
  Singular,       ///< a gradient vanishes or does not exist, or coordinates move the points the same way
  Contradictory,  ///< constraints contradict each other, or what is prescribed at supports
  NotConverged,   ///< an iteration (projection onto the constraints) stalled
  NotFinite,      ///< the state or the forces left the range of double
  StepTooSmall,   ///< the tolerance asks for steps below the resolution of time
  NoSolution,     ///< friction: no accelerations obey the law (Painleve); the velocity would have to jump
  NotUnique       ///< friction: several accelerations obey the law, and none is nearer than the others
};

/// A status with its explanation; `what` names the constraint, the time and the reason.
struct [[nodiscard]] Outcome {
  Status status = Status::Ok;
  std::string what;

  bool ok() const { return status == Status::Ok; }
};

}  // namespace tanor
