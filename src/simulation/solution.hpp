#pragma once

#include <span>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor {

/// Room for all arrays of a solution of the system, and where the equations of its members stand.
Solution make_solution(const System& system);

}  // namespace tanor
