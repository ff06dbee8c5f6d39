#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <tanor/motion.hpp>

#include "report/json_text.hpp"

/// Texts and objects about friction for the outputs.
namespace tanor::report {

/// Returns the object `friction_report` of `solve`. If the instant was not solved, every member is null.
Json describe_friction_report(const std::optional<FrictionReport>& report);

/// Counts the contacts that have friction.
std::size_t count_contacts(const System& system);

/// Returns the object `friction` of summary.json. Values that were not computed, or not proven, are null.
Json describe_friction_summary(std::size_t contacts, const FrictionSummary& summary);

/// Returns "rough (coulomb, exact, 3 contacts), oil (viscous, 1 contact)", or "none".
std::string describe_friction(const System& system);

/// Returns "2 contacts, 1 sticks, 4 iterations (anderson), uniqueness proven".
std::string describe_friction(const FrictionReport& report);

/// Returns "3.2 iterations an instant, 7 at most (anderson), contraction 0.31, uniqueness proven".
std::string describe_friction(const FrictionSummary& summary);
/// Says that the motion was not the only possible one; empty if no other is known.
std::string describe_several(const FrictionSummary& summary);

}  // namespace tanor::report
