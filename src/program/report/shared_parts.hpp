#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>
#include <tanor/motion.hpp>

#include "report/json_text.hpp"
#include "report/summary.hpp"
#include "system/members.hpp"

/// Common parts of summary.json and the answer of `solve`.
namespace tanor::report {

/// Returns a number of a state, or null if no start was found.
Json if_started(const RunFacts& facts, double number);
/// Returns the seconds of each phase of a run.
Json describe_times(const RunFacts& facts, const PhaseTimes& times, bool has_friction);

/// Returns false if there are coordinates alone, which have reactions but no multipliers.
bool has_multipliers(const PlanSummary& plan);

/// Returns the object `certificate` of docs/scene-format.md, with every check. Without a certificate every member is
/// null.
Json describe_certificate(const std::optional<Certificate>& certificate);

/// Returns `rank`, `degrees_of_freedom`, and `redundant` with a line for each equation that the rank lacks. Without a
/// rank they are null.
Json describe_rank(const std::optional<RankReport>& rank);

/// Returns "2 of 12 equations are redundant: bar[2] depends on bar[0], bar[1]; …", or an empty text if none is.
std::string describe_redundancy(const RankReport& rank);

/// Returns the object `friction_report` of `solve`. If the instant was not solved, every member is null.
Json describe_friction_report(const std::optional<FrictionReport>& report);

/// Returns where the equations of each group of constraints stand among all multipliers: its `name` and `kind`, its
/// `first` equation, its `members` and the `rows` of each.
Json list_groups(const System& system);

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
std::string describe_several(const FrictionSummary& summary, const Units& units);

/// Calls visit(name, number of the entry, first row, number of members) for each group of constraints.
template <class Visit>
void for_each_group(const System& system, const Visit& visit) {
  std::size_t row = 0;
  for (std::size_t g = 0; g < system.constraints.size(); ++g) {
    const auto [members, rows] = detail::shape_of(system.constraints[g]);
    visit(constraint_name(system, g), g, row, members);
    row += members * rows;
  }
}

}  // namespace tanor::report
