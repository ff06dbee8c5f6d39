#pragma once

#include <memory>

#include "dynamics/constrained_system.hpp"
#include "dynamics/roles.hpp"

namespace tanor::detail {

class Contacts;
class Workspace;

/// One-sided constraints as the equations with multipliers see them: rows with a gap g = s xi and a force p = s lambda,
///
///   0 <= g  _|_  p >= 0                                               (Signorini)
///
/// An open row is left out of K. Which rows are closed, impacts and events are in src/modules/contact.
class Unilateral : public EventFunctions {
 public:
  /// Closes the rows that touch at (t, r), also those with a gap below 0, which a projection brings there. Returns true
  /// if some of these were open. Throws InputError where a start that does not project is given such a gap.
  virtual bool close_touching(double t, const double* r, StartMode mode) = 0;
  /// Opens those of them that move at v.
  virtual void open_moving(double t, const double* r, const double* v) = 0;
  /// Solves the impact of the rows that touch and approach at a start, which changes v, then chooses the closed rows
  /// and computes the accelerations. Behind a `restore_discrete_state` it goes on from these rows and lists what
  /// changes.
  virtual Outcome begin(double t, const double* r, double* v, const Request& request, const AccelerationOutput& to) = 0;
  /// Exchanges what later events depend on beside the discrete state.
  virtual void exchange_memory(Memory& memory) = 0;
};

/// Makes the one-sided rows of a model that has some, from which `system` is made. `contacts` are their friction, whose
/// modes they then choose; null if there is none.
std::unique_ptr<Unilateral> make_unilateral(Workspace& work, ConstrainedSystem& system, Contacts* contacts);

}  // namespace tanor::detail
