#pragma once

#include <tanor/system.hpp>

namespace tanor {

/// Distances join what is joined already, where all supports and centers are one place; or some constraint is no
/// distance. Otherwise the constraints are a forest, whose gradients are independent wherever its points are.
bool closes_loops(const System& system);

}  // namespace tanor
