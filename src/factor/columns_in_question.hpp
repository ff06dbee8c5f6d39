#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor {

/// Columns of C that may depend on others, in groups without a row in common; both increase.
///
/// Rows are taken by threes, the places of a point. Where the part of a column in such three is not in the span of the
/// other columns' parts, no dependence has it,
///
///   v'c_q = 0 for all others q there  =>  v'C x = x_p v'c_p,
///
/// and without it others may stand out, too: what hangs on a free end goes rod by rod, and little is left that needs a
/// factor. Bounds of |x_p| over |C x| are carried along: a column stays in question where its own is above 1e-4 over
/// the tolerance, since rounding might then hide a dependence. C has columns of unit length.
std::vector<std::vector<int>> find_columns_in_question(const SparseColumns& C, double tolerance);

}  // namespace tanor
