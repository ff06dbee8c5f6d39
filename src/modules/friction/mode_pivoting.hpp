#pragma once

#include <span>
#include <vector>

#include "friction/contact_choices.hpp"

namespace tanor::detail {

/// Finds the modes of many contacts at rest by block pivoting. Sticking contacts above their limit are released against
/// the friction that held them. Released contacts that do not slide off are held again. This repeats until all obey the
/// law, with many contacts at once in the first passes, then one by one.
class ModePivoting {
 public:
  /// Both arguments must outlive this object.
  ModePivoting(ContactState& state, ContactChoices& choices) : state_(state), choices_(choices) {}

  /// Searches the islands that have changed for modes whose forces and accelerations are complementary: sticking
  /// contacts hold no more than their limit, and sliding contacts do not move backwards. `choices` are the islands that
  /// were solved as a whole; those that have shared a load stay as they are. `are_counted` [island] is as in
  /// ConstrainedSystem. Leaves the accelerations in `at.to`.
  Outcome find_complementary_modes(const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                                   const ContactIslands& islands, std::span<const char> are_counted);

 private:
  struct Search;
  Search begin(const ModeSwitch& at, const std::vector<ContactChoice>& choices, const ContactIslands& islands) const;
  Outcome look(Search* search) const;
  void look_at_sliding(std::size_t contact, const Vec3& a, Search* search) const;
  bool share_otherwise(Search* search);
  void give_way_together(Search* search);
  void release_worst(Search* search);
  void release_met(Search* search);
  void release(std::size_t contact) { state_.release(contact, state_.system.lambda().data()); }

  ContactState& state_;
  ContactChoices& choices_;
};

}  // namespace tanor::detail
