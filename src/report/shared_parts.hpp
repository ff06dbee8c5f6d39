#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/certificate.hpp>
#include <tanor/dynamics.hpp>

#include "report/json_writer.hpp"

/// What summary.json and the answer of `solve` have in common.
namespace tanor::report {

/// Coordinates alone have reactions, but no multipliers.
bool has_multipliers(const PlanSummary& plan);

/// The object `certificate` of the contract, and every check one by one; without one every member is null.
void write_certificate(JsonWriter* json, const std::optional<Certificate>& certificate);

/// `rank`, `degrees_of_freedom`, and `redundant`: a line for each equation that the rank lacks; without a rank null.
void write_rank(JsonWriter* json, const std::optional<RankReport>& rank);

/// "2 of 12 equations are redundant: bar[2] depends on bar[0], bar[1]; …"; empty where none is.
std::string describe_redundancy(const RankReport& rank);

/// The list `left_out`: what this system does not need.
void write_left_out(JsonWriter* json, const std::vector<std::string>& left_out);

}  // namespace tanor::report
