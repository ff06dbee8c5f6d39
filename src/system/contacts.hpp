#pragma once

#include <vector>

#include <tanor/system.hpp>

namespace tanor {

/// A moving point that slides, or sticks, on the guides that one entry of `System::friction` names.
struct Contact {
  Index friction;                 ///< place of the entry in System::friction
  Index point;                    ///< user's point
  std::vector<Index> guide_rows;  ///< user's rows of the guides at this point: its normal directions, 1 or 2
  bool can_stick;                 ///< by its law; then the tangent directions are rows of K as well

  int num_tangents() const { return 3 - static_cast<int>(guide_rows.size()); }
};

/// Whether points stick by this law: its force at rest is not a function of the velocity.
bool law_sticks(const Friction& friction);
/// What a law that sticks holds at rest, over |N|.
double static_coefficient_of(const Friction& friction);
/// Whether N is the whole reaction of the point.
bool reads_full_reaction(const Friction& friction);

/// All contacts, entry by entry, point by point. Supports have none (nothing moves them), nor have points that three
/// equations hold in place, nor a friction whose coefficient is 0.
std::vector<Contact> list_contacts(const System& system);

}  // namespace tanor
