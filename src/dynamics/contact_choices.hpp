#pragma once

#include <vector>

#include "dynamics/contact_reduction.hpp"
#include "dynamics/load_sharing.hpp"

namespace tanor {

/// Which contacts at rest stick and which begin to slide: islands of contacts as small dense problems, whose motions
/// are counted (docs/friction.md).
class ContactChoices {
 public:
  /// All must outlive it.
  ContactChoices(ContactState& state, FrictionSolver& friction, ConstrainedSystem& system, LoadSharing& sharing);

  /// Counts the motions of islands that are `wanted` [island] and have at most `most_contacts`, and sets the modes of
  /// what has a solution. `choices`: those islands, with what each takes. At a start several motions are refused.
  Outcome count(const ModeSwitch& at, const std::vector<char>& wanted, std::size_t most_contacts,
                ContactVerdict* verdict, std::vector<ContactChoice>* choices);
  /// Modes and shares become those of x, where contacts that stick share their load; of `all` choices: everywhere. What
  /// has no acceleration sticks. Where no share leaves a contact anything to spare, all accelerations are still 0, and
  /// nothing tells yet what will move: those are held a little longer, until what they lack rises above rounding
  /// (`ContactState::overload`).
  Outcome take(const ModeSwitch& at, bool all, std::vector<ContactChoice>* choices);
  /// Islands that were not counted have one motion where friction changes no reaction, or little (`is_monotone`).
  Outcome verify_uncounted(const ModeSwitch& at, const std::vector<char>& wanted, ContactVerdict* verdict);
  /// Contacts that bear all they can do so from now on: what they shared with others that stick is then determined.
  /// Returns whether there are some.
  bool set_limits(const std::vector<ContactChoice>& choices);

 private:
  std::vector<std::size_t> free_members(const std::vector<ContactChoice>& choices);
  void hold_again(const std::vector<std::size_t>& contacts);
  Outcome solve_without_members(const ModeSwitch& at, ContactVerdict* verdict, std::vector<ContactChoice>* choices);
  void choose(bool is_start, const std::vector<char>& released, ContactChoice* choice) const;
  void solve(std::vector<char> released, std::size_t most_modes, ContactChoice* choice) const;
  bool release_moving(const ContactChoice& choice, std::vector<char>* released) const;
  void find_share(bool is_start, ContactChoice* choice) const;
  void set_modes(const ModeSwitch& at, const ContactChoice& choice);
  bool is_left_to_search(const ModeSwitch& at, const ContactChoice& choice) const;
  void take_one(const ModeSwitch& at, ContactChoice* choice);
  Outcome explain(double t, const ContactChoice& choice) const;
  ContactPlace place(const ModeSwitch& at) const { return {at.t, at.r, at.v, system_.blocks().data()}; }

  ContactState& state_;
  FrictionSolver& friction_;
  ConstrainedSystem& system_;
  LoadSharing& sharing_;
  ContactReduction reduction_;
};

}  // namespace tanor
