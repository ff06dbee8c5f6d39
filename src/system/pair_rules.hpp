#pragma once

#include <functional>
#include <string>

#include <tanor/system.hpp>

namespace tanor {

/// Distance from which on a pair feels nothing, m; infinite for Log.
double cutoff_of(const PairForces& pairs);

/// What a group of pair forces must be beyond points that exist; `is_support` tells the points whose pairs do not
/// count. Throws InputError with the JSON pointer `where` of the group.
void check_pair_rules(const System& system, const PairForces& pairs, const std::function<bool(Index)>& is_support,
                      const std::string& where);

}  // namespace tanor
