#pragma once

#include <vector>

#include "dynamics/guide_motion.hpp"
#include "dynamics/workspace.hpp"
#include "schur/redundancy.hpp"

namespace tanor {

/// Where contacts that stick are held: T'(r - p) = 0 beside T'(v - u) = 0, so that nothing creeps. On a guide that
/// moves the place p moves with it (GuideMotion), from the last step that was accepted to wherever the places are asked
/// for: steps that are tried and given up leave no trace.
class HeldPlaces {
 public:
  explicit HeldPlaces(Workspace& work);

  /// At t: contacts that stick and are not held are held at r from now on, contacts that slide are let go.
  void hold(double t, const double* r);
  /// None is held.
  void forget();
  /// The places at t, into the Tangents.
  void carry(double t);
  /// The step to t was accepted: from now on places come from there.
  void accept(double t);

  /// Places that other constraints do not let be reached give way: those contacts are held where they are.
  void give_way(const double* r);
  /// Largest |T'(r - place)| over the length around it; `rows` [rows] = xi(r). Rows that depend on others do not
  /// decide.
  double largest_violation(const double* rows, const Redundancy& redundancy) const;

  bool holds(std::size_t contact) const { return is_held_[contact] != 0; }

  void exchange_memory(Memory& memory);

 private:
  /// The places at one time.
  struct Instant {
    double time;
    std::vector<Vec3> places, rest;  // [contact]; what rounding has left out of them
  };
  void list_held();
  void publish();
  /// Contacts that are held.
  const std::vector<std::size_t>& held() const { return motion_.contacts(); }

  Tangents& tangents_;
  GuideMotion motion_;
  std::vector<char> is_held_;      // [contact]
  Instant then_, now_;             // the last accepted step, and where places were asked for last
  GuideMotion::Places on_guides_;  // scratch
};

}  // namespace tanor
