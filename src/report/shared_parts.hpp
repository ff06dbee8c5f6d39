#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/dynamics.hpp>

#include "report/json_writer.hpp"

/// What summary.json and the answer of `solve` have in common.
namespace tanor::report {

/// "normal" or "tangent": the form that answers.
std::string_view name_form(const PlanSummary& plan);
/// Coordinates alone have reactions, but no multipliers.
bool has_multipliers(const PlanSummary& plan);

/// Proof of an answer. The identities (9), (10), (15), (16) are not computed in this version.
struct Certificate {
  double residual = 0.0;              ///< max |K'w + phi| / (sum of the magnitudes of its terms)
  double reciprocal_condition = 0.0;  ///< of the scaled S or H
  std::optional<double> forms_agree{};  ///< relative difference of w and eta between both forms
};

/// The object `certificate` of the contract; without one every member is null.
void write_certificate(JsonWriter* json, const std::optional<Certificate>& certificate);

/// The list `left_out`: what this system does not need.
void write_left_out(JsonWriter* json, const std::vector<std::string>& left_out);

}  // namespace tanor::report
