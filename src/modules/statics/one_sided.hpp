#pragma once

#include <span>
#include <string>
#include <vector>

#include "contact/exchange.hpp"
#include "statics/equilibrium_equations.hpp"
#include "statics/statics_input.hpp"

namespace tanor::detail {

/// Rows of the whole system, in the user's order.
using UserRows = std::vector<std::size_t>;

/// Moves the sides of constraints into the options, which are returned. Throws InputError.
EquilibriumOptions take_sides(System* system, const EquilibriumOptions& given);

/// Returns true for each equation of constraints with a side that keep their distance at `positions` [3n]; nothing if
/// none does. Throws InputError.
std::vector<bool> find_open_rows(const System& system, std::span<const double> positions,
                                 const EquilibriumOptions& options);

/// Returns those of the numbers of the rows from `first` on that are not `open` [row].
std::vector<double> keep_rows(const std::vector<double>& all, const std::vector<bool>& open, std::size_t first = 0);
/// Returns the numbers of all rows; those of open ones are 0.
std::vector<double> spread_rows(const std::vector<double>& kept, const std::vector<bool>& open);
/// Replaces the numbers that members have without the open rows by those of the user.
void rename_members(const System& system, const std::vector<bool>& open, std::string* text);

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
