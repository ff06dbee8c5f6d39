#pragma once

#include <vector>

#include "dynamics/dependences.hpp"
#include "dynamics/workspace.hpp"
#include "friction/guide_motion.hpp"

namespace tanor::detail {

/// The places where sticking contacts are held: T'(r - p) = 0 beside T'(v - u) = 0, so that they do not creep. On a
/// moving guide the place p moves with the guide (GuideMotion), from the last accepted step to the requested time.
/// Rejected steps leave no trace.
class HeldPlaces {
 public:
  explicit HeldPlaces(Workspace& work);

  /// Holds at r, at the time t, all contacts that stick and are not held yet. Releases the contacts that slide.
  void hold(double t, const double* r);
  /// Releases all contacts.
  void forget();
  /// Moves the places to t and passes them to the Tangents.
  void carry(double t);
  /// Accepts the step to t; places start from there from now on.
  void accept(double t);

  /// Moves to r the places that other constraints keep from being reached.
  void give_way(const double* r);
  /// Returns the largest |T'(r - place)| over the length around it, for `rows` [rows] = xi(r). Dependent rows do not
  /// count.
  double largest_violation(const double* rows, const Dependences& redundancy) const;

  bool holds(std::size_t contact) const { return is_held_[contact] != 0; }

  void exchange_memory(Memory& memory);

 private:
  /// The places at one time.
  struct Instant {
    double time;
    std::vector<Vec3> places, rest;  // [contact] places, and their rounding errors
  };
  void list_held();
  void publish();
  /// The contacts that are held.
  const std::vector<std::size_t>& held() const { return motion_.contacts(); }

  Tangents& tangents_;
  GuideMotion motion_;
  std::vector<char> is_held_;      // [contact]
  Instant then_, now_;             // at the last accepted step, and at the last requested time
  GuideMotion::Places on_guides_;  // scratch
};

}  // namespace tanor::detail
