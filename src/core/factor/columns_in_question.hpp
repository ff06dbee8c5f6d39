#pragma once

#include <vector>

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// Returns the columns of C that may depend on others, in groups that have no row in common. Groups and their columns
/// are in increasing order.
///
/// Rows are taken in triples, the components of a point. If the part of a column in such a triple is not in the span of
/// the other columns' parts there, no dependence contains this column,
///
///   v'c_q = 0 for all others q there  =>  v'C x = x_p v'c_p,
///
/// and without it more columns may stand out. Chains with a free end dissolve rod by rod in this way, and little is
/// left that needs a factor. Bounds of |x_p| over |C x| are carried along. A column stays in question if its own bound
/// is above 1e-4 over the tolerance, since rounding might then hide a dependence. C must have columns of unit length.
std::vector<std::vector<int>> find_columns_in_question(const SparseColumns& C, double tolerance);

}  // namespace tanor::detail
