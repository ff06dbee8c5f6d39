#pragma once

#include <span>

#include <tanor/system.hpp>

#include "observe/arguments.hpp"

namespace tanor::detail {

/// Returns a system without some members of its constraints and forces, and with some of its supports let go.
///
/// Points, members of constraints and equations keep their numbers: a constraint that is taken out joins new supports
/// outside, behind the points of the system, and its equations become idle. A point that is let go starts with its own
/// mass. What moves as a function of time stays as at the start of the motion, t; the result serves as a check alone if
/// that is NaN. Throws InputError for a support without mass, and for members of guides that turn or move by a vector,
/// which cannot be let go.
System without(const System& system, std::span<const Thing> taken, double t);

}  // namespace tanor::detail
