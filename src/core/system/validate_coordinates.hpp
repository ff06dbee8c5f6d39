#pragma once

#include <limits>
#include <span>

#include <tanor/system.hpp>

namespace tanor::detail {

/// Marks a [point] that is no support.
inline constexpr std::size_t no_support = std::numeric_limits<std::size_t>::max();

/// The part of `validate` for coordinates: checks their values at t, and that every point that moves is covered once.
/// `support_of_point` [point] is its entry of `system.supports`, or `no_support`. All else is valid already.
void validate_coordinates(const System& system, std::span<const std::size_t> support_of_point, double t);

}  // namespace tanor::detail
