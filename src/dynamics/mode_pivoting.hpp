#pragma once

#include <span>
#include <vector>

#include "dynamics/contact_choices.hpp"

namespace tanor {

/// The modes of many contacts at rest by block pivoting. Contacts that stick and cannot are released against what held
/// them, and what does not slide off then is held again, until all obey the law; many at once while that goes well,
/// then one by one.
class ModePivoting {
 public:
  /// All must outlive it.
  ModePivoting(ContactState& state, ConstrainedSystem& system, LoadSharing& sharing, ContactChoices& choices)
      : state_(state), system_(system), sharing_(sharing), choices_(choices) {}

  /// Searches the islands that have changed for modes whose forces and accelerations are complementary: what sticks
  /// holds no more than it can, what slides off does not come back. `choices`: those that were solved as a whole; what
  /// has shared a load stands as it is. `are_counted` [island]: as in ConstrainedSystem. Leaves the accelerations in
  /// `at.to`.
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
  void release(std::size_t contact) { state_.release(contact, system_.lambda().data()); }

  ContactState& state_;
  ConstrainedSystem& system_;
  LoadSharing& sharing_;
  ContactChoices& choices_;
};

}  // namespace tanor
