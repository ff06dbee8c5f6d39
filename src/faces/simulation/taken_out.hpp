#pragma once

#include <span>

#include <tanor/system.hpp>

#include "observe/arguments.hpp"

namespace tanor::detail {

/// Throws InputError for a support without mass, which cannot be let go.
void check_let_go(const System& system, const Thing& thing);

/// Returns a system without some members of its constraints and forces, and with some of its supports let go.
///
/// Points, members of constraints and equations keep their numbers: a constraint that is taken out joins new supports
/// outside, behind the points of the system, and its equations, which nobody evaluates, become idle. A point that is
/// let go starts with its own mass. The numbers of what went stay as at the start of the motion, t.
System without(const System& system, std::span<const Thing> taken, double t);

}  // namespace tanor::detail
