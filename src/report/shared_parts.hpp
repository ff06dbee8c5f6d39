#pragma once

#include <optional>
#include <string>

#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>

#include "report/json_text.hpp"
#include "report/summary.hpp"

/// What summary.json and the answer of `solve` have in common.
namespace tanor::report {

/// A number of a state, which is not known without a start.
Json if_started(const RunFacts& facts, double number);

/// Coordinates alone have reactions, but no multipliers.
bool has_multipliers(const PlanSummary& plan);

/// The object `certificate` of docs/scene-format.md, with every check; without a certificate every member is null.
Json describe_certificate(const std::optional<Certificate>& certificate);

/// Adds `rank`, `degrees_of_freedom`, and `redundant`: a line for each equation that the rank lacks; without a rank
/// they are null.
void add_rank(const std::optional<RankReport>& rank, JsonObjectFile* json);

/// "2 of 12 equations are redundant: bar[2] depends on bar[0], bar[1]; …"; empty where none is.
std::string describe_redundancy(const RankReport& rank);
}  // namespace tanor::report
