#pragma once

#include <vector>

#include "dynamics/dependences.hpp"

namespace tanor::detail {

/// Returns multipliers [rows] that act on no moving point, with a part in each one that is not unique by the last
/// decision on the rank; empty if all are unique.
std::vector<double> find_self_stress(const Dependences& dependences, const Numbering& numbering);

}  // namespace tanor::detail
