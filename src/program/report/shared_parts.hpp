#pragma once

#include <optional>
#include <string>

#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>

#include "report/json_text.hpp"
#include "report/summary.hpp"

/// Common parts of summary.json and the answer of `solve`.
namespace tanor::report {

/// Returns a number of a state, or null if no start was found.
Json if_started(const RunFacts& facts, double number);

/// Returns false if there are coordinates alone, which have reactions but no multipliers.
bool has_multipliers(const PlanSummary& plan);

/// Returns the object `certificate` of docs/scene-format.md, with every check. Without a certificate every member is
/// null.
Json describe_certificate(const std::optional<Certificate>& certificate);

/// Adds `rank`, `degrees_of_freedom`, and `redundant` with a line for each equation that the rank lacks. Without a rank
/// they are null.
void add_rank(const std::optional<RankReport>& rank, JsonObjectFile* json);

/// Returns "2 of 12 equations are redundant: bar[2] depends on bar[0], bar[1]; …", or an empty text if none is.
std::string describe_redundancy(const RankReport& rank);
}  // namespace tanor::report
