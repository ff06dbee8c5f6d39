#pragma once

#include <span>
#include <string>

#include <tanor/system.hpp>

namespace tanor::detail {

/// The part of `validate` for friction: checks that its guides exist and let their points slide, and its numbers at t.
/// `support_of_point` [point] is its entry of `system.supports`, or `no_support`. All else is valid already.
void validate_friction(const System& system, std::span<const std::size_t> support_of_point, double t);
/// Refuses what is not known of friction in a system with constraints to one side; messages start with `beside`.
void validate_friction_beside_sides(const System& system, const std::string& beside);

}  // namespace tanor::detail
