#pragma once

#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// A moving point that slides, or sticks, on the guides that one entry of `System::friction` names.
struct Contact {
  Index friction;                 ///< place of the entry in System::friction
  Index point;                    ///< user's point
  std::vector<Index> guide_rows;  ///< user's rows of the guides at this point: its normal directions, 1 or 2
  bool can_stick;                 ///< true if its law sticks; then the tangent directions are rows of K as well

  int num_tangents() const { return 3 - static_cast<int>(guide_rows.size()); }
};

/// True if points stick by this law, whose force at rest is then not a function of the velocity.
bool law_sticks(const Friction& friction);
/// Returns the largest friction at rest over |N| of a law that sticks.
double static_coefficient_of(const Friction& friction);
/// True if N is the whole reaction of the point.
bool reads_full_reaction(const Friction& friction);

/// Lists all contacts, entry by entry, point by point. Supports, which nothing moves, have no contacts, nor have points
/// that three equations hold in place. A friction whose coefficient is 0 makes none.
std::vector<Contact> list_contacts(const System& system);

}  // namespace tanor::detail
