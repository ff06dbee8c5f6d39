#pragma once

#include <vector>

#include "friction/contact_reduction.hpp"

namespace tanor::detail {

/// Chooses which contacts at rest stick and which begin to slide. Islands of contacts become small dense problems,
/// whose motions are counted (docs/friction.md).
class ContactChoices {
 public:
  /// Both arguments must outlive this object.
  ContactChoices(ContactState& state, FrictionSolver& friction)
      : state_(state), friction_(friction), reduction_(state, friction) {}

  /// Counts the motions of the islands that are `wanted` [island] and have at most `most_contacts` contacts. Sets the
  /// modes of those with a solution. `choices` receives these islands with what each has chosen. At a start several
  /// motions are refused.
  Outcome count(const ModeSwitch& at, const std::vector<char>& wanted, std::size_t most_contacts,
                ContactVerdict* verdict, std::vector<ContactChoice>* choices);
  /// Sets modes and shares from x where contacts that stick share their load, or everywhere if `all` is true. Contacts
  /// without acceleration stick. Where no share leaves a contact anything to spare, all accelerations are still 0 and
  /// do not tell yet which contacts will move. Such contacts are held until their load exceeds its limit by more than
  /// rounding (`ContactState::overload`).
  Outcome take(const ModeSwitch& at, bool all, std::vector<ContactChoice>* choices);
  /// Adds the verdict on islands that were not counted. Their motion is unique where friction changes reactions little
  /// or not at all (`is_proven_unique`).
  Outcome verify_uncounted(const ModeSwitch& at, const std::vector<char>& wanted, ContactVerdict* verdict);
  /// Lets the contacts at their limit slide, so that the load which they shared with others becomes determined. Returns
  /// true if there are any.
  bool set_limits(const std::vector<ContactChoice>& choices);

 private:
  std::vector<std::size_t> free_members(const std::vector<ContactChoice>& choices);
  void hold_again(const std::vector<std::size_t>& contacts);
  Outcome solve_without_members(const ModeSwitch& at, ContactVerdict* verdict, std::vector<ContactChoice>* choices);
  void choose(bool is_start, const std::vector<char>& met, ContactChoice* choice) const;
  void solve(bool is_start, std::vector<char> released, const std::vector<double>& lowered, std::size_t* work_left,
             ContactChoice* choice) const;
  bool lower_overloaded(const ContactChoice& choice, const std::vector<char>& met, std::vector<double>* lowered) const;
  bool release_beginning(const ContactChoice& choice, std::vector<char>* released) const;
  void find_share(bool is_start, ContactChoice* choice) const;
  void set_modes(const ModeSwitch& at, const ContactChoice& choice);
  bool is_left_to_search(const ModeSwitch& at, const ContactChoice& choice) const;
  void take_one(const ModeSwitch& at, ContactChoice* choice);
  Outcome explain(double t, const ContactChoice& choice) const;

  ContactState& state_;
  FrictionSolver& friction_;
  ContactReduction reduction_;
};

}  // namespace tanor::detail
