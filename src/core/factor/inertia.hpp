#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor::detail {

/// Counts the negative eigenvalues of a symmetric matrix by the signs of the pivots of L D L', in the order in which
/// its rows stand (Sylvester). `upper` is its upper triangle, with `values` beside its rows. Returns nothing if a pivot
/// vanishes, because the matrix is singular or needs another order.
std::optional<std::size_t> count_negative_eigenvalues(const TrianglePattern& upper, std::vector<double> values);

}  // namespace tanor::detail
