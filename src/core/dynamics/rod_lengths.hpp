#pragma once

#include <tanor/error.hpp>

#include "dynamics/model.hpp"

namespace tanor::detail {

/// Returns a failure if a rod is longer at t than a way between its ends, along other rods and from support to support:
/// no configuration has such lengths. r [3n] places the supports.
Outcome check_rod_lengths(const Model& model, double t, const double* r);

}  // namespace tanor::detail
