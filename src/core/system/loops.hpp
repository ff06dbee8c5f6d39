#pragma once

#include <tanor/system.hpp>

namespace tanor::detail {

/// True if some distance joins points that are joined already, all supports and centers counting as one place, or if
/// some constraint is no distance. Otherwise the constraints are a forest, whose gradients are independent wherever its
/// points are.
bool closes_loops(const System& system);

}  // namespace tanor::detail
