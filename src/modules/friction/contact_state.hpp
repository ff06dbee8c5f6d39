#pragma once

#include <span>
#include <string>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/workspace.hpp"
#include "friction/held_places.hpp"
#include "friction/laws.hpp"

namespace tanor::detail {

/// The worst that was noted about the uniqueness of the motion since the modes were counted last.
struct ContactVerdict {
  Uniqueness uniqueness = Uniqueness::NotAsked;
  std::string reason;

  void note(Uniqueness other, const std::string& why) {
    if (other <= uniqueness) return;
    uniqueness = other;
    reason = why;
  }
};

/// The discrete state of all contacts, and what is known about it. `tangents` know which contacts stick, and `laws` in
/// which direction the others slide. A contact that sticks has in addition a place and a softness by which it shares a
/// load, and may be held a little above its limit.
struct ContactState {
  /// Both arguments must outlive it.
  ContactState(Workspace& work, ConstrainedSystem& system);

  /// Steps of softness for each factor of two.
  static constexpr int softness_steps = 1 << 20;
  /// A share is accurate to 1e-9 of itself. A contact nearer than `to_spare` to its limit is held until its load is
  /// `overload` above it.
  static constexpr double to_spare = 1e-8, overload = 4e-8;

  Workspace& work;
  ConstrainedSystem& system;
  const Model& model;
  Tangents& tangents;
  FrictionLaws laws;
  HeldPlaces places;
  std::size_t num_switches = 0;  ///< contacts that may stick
  std::vector<int> softness;     ///< [contact] 0: softest
  std::vector<char> overloads;   ///< [contact] held until `overload` above its limit
  bool shares_loads = false;  ///< the contacts that stick depend on constraints or on each other; see `begin_sharing`
  ContactVerdict verdict;

  std::size_t size() const { return tangents.size(); }
  ContactPlace place(double t, const double* r, const double* v) const { return {t, r, v, system.blocks().data()}; }
  bool may_stick(std::size_t contact) const { return tangents[contact].first_row >= 0; }
  /// Returns true if the contact may stick at present: a one-sided guide may be open.
  bool may_rest(std::size_t contact) const { return may_stick(contact) && !tangents.is_open(contact); }
  std::size_t neighbourhood(std::size_t contact) const {
    return work.scales.of_point(static_cast<std::size_t>(tangents[contact].point));
  }
  double mass(std::size_t contact) const { return model.mass[static_cast<std::size_t>(tangents[contact].point)]; }

  /// Returns the speed below which a contact is at rest, m/s: the rounding of projected velocities.
  double sliding_threshold(std::size_t contact) const;
  double sliding_speed(std::size_t contact, const double* v) const {
    return norm(tangents.sliding_velocity(contact, v));
  }
  bool is_at_rest(std::size_t contact, const double* v) const {
    return sliding_speed(contact, v) <= sliding_threshold(contact);
  }
  /// Passes the speeds around the contacts to the laws. Call this when they are known or have changed.
  void set_sliding_speeds();

  /// The friction that a sticking contact holds at lambda [rows], and the friction at which it gives way, N.
  double held(std::size_t contact, const double* lambda) const { return norm(laws.held(contact, lambda)); }
  double limit(std::size_t contact, const double* lambda) const;
  /// Lets the contact slide from now on, against the friction that holds it at lambda.
  void release(std::size_t contact, const double* lambda);
  /// Lets the contact slide from now on, in the direction of its motion.
  void let_slide(std::size_t contact);

  /// Forgets where the contact slid to, and how it shared a load.
  void forget(std::size_t contact);

  /// Contacts that stick may hold more than can move. Then no law divides the load among them, and the least friction
  /// that holds is taken. A small compliance of their rows in the factor of S finds it, and refinement removes the
  /// compliance again, since refined solutions lie in the range of S. Returns true if S must be factorized again, and
  /// false if nothing sticks or rows are compliant already.
  bool begin_sharing();
  /// Makes no row compliant. Call this when the set of sticking contacts or their shares have changed, so that
  /// redundancy is decided again.
  void forget_shares();
  /// Returns true if some sticking contacts have references, so that they hold more than can move.
  bool has_references() const;
  /// Makes contacts the more compliant the nearer they are to their limits (Lawson's algorithm for the share in which
  /// the most loaded contact has most to spare). `loads` [contact] are held over limit of those that stick, otherwise
  /// negative.
  void share_again(const std::vector<double>& loads);

  /// Returns one number for each contact, which tells its whole state but reference and place. Returns an empty vector
  /// where no contact may stick.
  std::vector<int> discrete_state() const;
  /// Returns "rough at hoop[0], point 0 sticks" for the first contact whose mode is another than in a state before.
  std::string describe_change(std::span<const int> before) const;
  /// Throws InputError if the size does not fit. Slip directions need T, so `restore_slip_directions` restores them at
  /// the first configuration where T is known. It does nothing in later calls.
  void restore_discrete_state(std::span<const int> state);
  void restore_slip_directions(const double* r, const double* v);
  /// Leaves them as they are, as a start chooses its own.
  void forget_restored() { restored_.clear(); }

  /// Adds to the report of one instant what is known about all modes and about reactions.
  void add_verdict(FrictionReport* report) const;
  /// Names a contact whose reaction depends on how dependent constraints share their load, or returns an empty string.
  /// Its motion is determined by convention only.
  std::string find_undetermined_reaction() const;

 private:
  std::vector<int> restored_;  // modes whose slip directions are not restored yet
};

}  // namespace tanor::detail
