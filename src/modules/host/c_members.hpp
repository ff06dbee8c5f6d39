#pragma once

#include <tanor.h>

#include <vector>

#include <tanor/constrainer.hpp>

namespace tanor::detail {

/// Adds members laid out as in tn_add, in groups of neighbours with the same shape. If one of them is wrong, none is
/// added. Returns their ids.
std::vector<ConstraintId> add_members(Constrainer* constrainer, tn_kind kind, size_t count, const int32_t* points,
                                      const double* parameters);

}  // namespace tanor::detail
