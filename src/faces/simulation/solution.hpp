#pragma once

#include <cstddef>

#include <tanor/dynamics.hpp>

namespace tanor::detail {

/// Makes room for all arrays of a solution of the system (in so many coordinates), and notes where the equations of its
/// members stand.
Solution make_solution(const System& system, std::size_t num_coordinates);

}  // namespace tanor::detail
