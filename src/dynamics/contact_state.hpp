#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/held_friction.hpp"
#include "dynamics/held_places.hpp"
#include "dynamics/workspace.hpp"
#include "friction/laws.hpp"
#include "schur/redundancy.hpp"

namespace tanor {

/// What is known of all motions since the modes were counted last: the worst that was noted.
struct ContactVerdict {
  Uniqueness uniqueness = Uniqueness::NotAsked;
  std::string reason;

  void note(Uniqueness other, const std::string& why) {
    if (other <= uniqueness) return;
    uniqueness = other;
    reason = why;
  }
};

/// The discrete state of all contacts, and what is known about it. `tangents` know which ones stick, `laws` to where
/// the others slide; beside that a contact that sticks has a place, a softness by which it shares a load, and may be
/// held a little above its limit.
struct ContactState {
  /// `work` must outlive it.
  explicit ContactState(Workspace& work);

  /// An octave of softness.
  static constexpr int softness_steps = 1 << 20;
  /// A share is set to 1e-7 of itself: nearer than `to_spare` to its limit a contact is held until it is `overload`
  /// above it.
  static constexpr double to_spare = 1e-6, overload = 4e-6;

  Workspace& work;
  const Model& model;
  Tangents& tangents;
  FrictionLaws laws;
  HeldPlaces places;
  std::size_t num_switches = 0;  ///< contacts that may stick
  std::vector<int> softness;     ///< [contact] 0: softest; empty: all are alike
  std::vector<char> overloads;   ///< [contact] held until `overload` above its limit; empty: none is
  bool shares_loads = false;     ///< those that stick depend on constraints, or on each other; see LoadSharing
  ContactVerdict verdict;

  std::size_t size() const { return tangents.size(); }
  bool may_stick(std::size_t contact) const { return tangents[contact].first_row >= 0; }
  std::size_t neighbourhood(std::size_t contact) const {
    return work.scales.of_point(static_cast<std::size_t>(tangents[contact].point));
  }
  double mass(std::size_t contact) const { return model.mass[static_cast<std::size_t>(tangents[contact].point)]; }

  /// Sliding slower than this is rest, m/s: the rounding of projected velocities.
  double sliding_threshold(std::size_t contact) const;
  double sliding_speed(std::size_t contact, const double* v) const {
    return norm(tangents.sliding_velocity(contact, v));
  }
  bool is_at_rest(std::size_t contact, const double* v) const {
    return sliding_speed(contact, v) <= sliding_threshold(contact);
  }
  /// The speeds around the contacts are known, or have changed.
  void set_sliding_speeds();

  /// Friction that a contact which sticks holds at lambda [rows], and how much it may hold before it gives way, N.
  double held(std::size_t contact, const double* lambda) const {
    return norm(held_friction(tangents, laws, contact, lambda));
  }
  double limit(std::size_t contact, const double* lambda) const;
  /// From now on it slides, against what holds it at lambda.
  void release(std::size_t contact, const double* lambda);
  /// From now on it slides, to where it moves.
  void let_slide(std::size_t contact);

  /// One number a contact that tells all of it but references and places; none where no contact may stick.
  std::vector<int> discrete_state() const;
  /// Throws InputError where the size does not fit. Slip directions need T: they are restored at the first place where
  /// it stands, by `restore_slip_directions`, which does nothing but then.
  void restore_discrete_state(std::span<const int> state);
  void restore_slip_directions(const double* r, const double* v);

  /// What is known about all modes, and about reactions, into the report of one instant. K as blocks, and which of its
  /// rows depend on others.
  void add_verdict(const std::vector<double>& blocks, const Redundancy& redundancy, FrictionReport* report) const;
  /// Dependent constraints share their load in many ways: a contact whose reaction depends on the share has no motion
  /// but by convention. Names it; empty: there is none.
  std::string find_undetermined_reaction(const std::vector<double>& blocks, const Redundancy& redundancy) const;

 private:
  std::vector<int> restored_;  // modes whose slip directions are still to be found
};

}  // namespace tanor
