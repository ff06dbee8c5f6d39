#pragma once

#include <functional>
#include <string>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns the distance from which on a pair has no force, m; infinite for Log.
double cutoff_of(const PairForces& pairs);

/// Calls visit(i, j) for any two of the points that start at the same place of the periodic box.
void for_each_meeting(const System& system, const Vector3& box, const std::vector<Index>& points,
                      const std::function<void(Index i, Index j)>& visit);

/// Checks the rules for a group of pair forces, except that its points exist. `is_support` is true for points whose
/// pairs do not count. Throws InputError with the JSON pointer `where` of the group.
void check_pair_rules(const System& system, const PairForces& pairs, const std::function<bool(Index)>& is_support,
                      const std::string& where);

}  // namespace tanor::detail
