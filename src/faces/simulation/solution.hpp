#pragma once

#include <cstddef>
#include <initializer_list>
#include <span>
#include <vector>

#include <tanor/dynamics.hpp>

#include "dynamics/forms.hpp"

namespace tanor::detail {

/// Makes room for all arrays of a solution of the system (in so many coordinates), and notes where the equations of its
/// members stand.
Solution make_solution(const System& system, std::size_t num_coordinates);

/// Makes the multipliers of equations, and `forces` on the points that they join, unknown (NaN). The equations
/// increase.
void forget_equations(const System& system, std::span<const std::size_t> equations, std::vector<double>* multipliers,
                      std::initializer_list<std::vector<double>*> forces);
inline void forget_equations(const System& system, std::span<const std::size_t> equations, Solution* at) {
  forget_equations(system, equations, &at->multipliers, {&at->reactions, &at->support_forces});
  at->has_prestress = at->has_prestress || !equations.empty();
}

/// Returns the self-stress of Solution by the last decision on the rank, in the user's order.
std::vector<double> find_self_stress(const Forms& forms);

}  // namespace tanor::detail
