#pragma once

#include <tanor/system.hpp>

namespace tanor {

/// Whether Forces::evaluate_derivatives knows these pairs: their law is smooth, without a cutoff, and they are few.
bool has_stiffness(const System& system, const PairForces& pairs);

}  // namespace tanor
