#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/json_writer.hpp"

/// What summary.json and the answer of `solve` have in common.
namespace tanor::report {

/// Proof of an answer. This version knows the normal form alone: the identities (9), (10), (15), (16) and the
/// agreement of two forms are not computed.
struct Certificate {
  double residual = 0.0;              ///< max |K'w + phi| / (sum of the magnitudes of its terms)
  double reciprocal_condition = 0.0;  ///< of the scaled S
};

/// The object `certificate` of the contract; without one every member is null.
void write_certificate(JsonWriter* json, const std::optional<Certificate>& certificate);

/// The list `left_out`: what this system does not need.
void write_left_out(JsonWriter* json, const std::vector<std::string>& left_out);

}  // namespace tanor::report
