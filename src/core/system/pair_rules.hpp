#pragma once

#include <functional>
#include <string>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Returns the distance from which on a pair has no force, m; infinite for Log.
double cutoff_of(const PairForces& pairs);

/// Checks the rules for a group of pair forces, except that its points exist. `is_support` is true for points whose
/// pairs do not count. Throws InputError with the JSON pointer `where` of the group.
void check_pair_rules(const System& system, const PairForces& pairs, const std::function<bool(Index)>& is_support,
                      const std::string& where);

}  // namespace tanor::detail
