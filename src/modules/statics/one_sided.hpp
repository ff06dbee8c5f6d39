#pragma once

#include <vector>

#include "contact/exchange.hpp"
#include "statics/equilibrium_equations.hpp"
#include "statics/statics_input.hpp"

namespace tanor::detail {

/// Rows of the whole system, in the user's order.
using UserRows = std::vector<std::size_t>;

/// Moves the sides of constraints into the options, which are returned. Throws InputError.
EquilibriumOptions take_sides(System* system, const EquilibriumOptions& given);

/// Finds the equilibrium of a system whose constraints all act both ways, in a frame whose inertia is among the forces,
/// from `start` [3n]. If `assesses_stability` is false, any equilibrium is accepted and its stability is not computed.
EquilibriumResult rest_from(const System& system, const SteadyFrame& frame, const EquilibriumOptions& options,
                            const std::vector<double>& prestress, const std::vector<double>& start,
                            bool assesses_stability);

/// Alternates between equilibria with the closed one-sided constraints and changes of this set, until no closed one
/// pulls and no open one is broken (the primal-dual active sets of Hintermueller, Ito & Kunisch 2002). Only then is the
/// stability computed; if that leads away from an unstable equilibrium, rounds continue from there. Throws InputError.
EquilibriumResult rest_with_one_sided(const StaticsInput& input, const EquilibriumOptions& options);

}  // namespace tanor::detail
