#pragma once

#include <cstddef>
#include <span>

#include <tanor/dynamics.hpp>

namespace tanor::detail {

/// Makes room for all arrays of a solution of the system (in so many coordinates), and notes where the equations of its
/// members stand.
Solution make_solution(const System& system, std::size_t num_coordinates);

/// Makes the multipliers of equations, and the forces on the points that they join, unknown (NaN). The equations
/// increase.
void forget_equations(const System& system, std::span<const std::size_t> equations, Solution* at);

}  // namespace tanor::detail
