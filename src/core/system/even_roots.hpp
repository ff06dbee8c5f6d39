#pragma once

#include <cstddef>
#include <vector>

#include "system/formula.hpp"

namespace tanor::detail {

/// Replaces the last operand of a program by its power p if it is a product of even powers: (c f^2 g^4)^p with c > 0 is
/// c^p |f|^2p |g|^4p, which has derivatives on both sides of f = 0 and at it. Returns false if it is no such product.
bool append_even_root(double p, std::vector<Formula::Instruction>* program);

}  // namespace tanor::detail
