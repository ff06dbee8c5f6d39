#pragma once

#include <tanor.h>

#include <vector>

#include <tanor/constrainer.hpp>

namespace tanor {

/// Members as tn_add has them, in groups of neighbours with the same shape; where one of them is wrong none is added.
/// Returns their ids.
std::vector<ConstraintId> add_members(Constrainer* constrainer, tn_kind kind, size_t count, const int32_t* points,
                                      const double* parameters);

}  // namespace tanor
