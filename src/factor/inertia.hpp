#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "factor/cholesky.hpp"

namespace tanor {

/// How many eigenvalues of a symmetric matrix are negative: the signs of the pivots of L D L', in the order in which
/// its rows stand (Sylvester). `upper`: its upper triangle, `values` beside its rows. Empty: a pivot vanishes, so that
/// the matrix is singular or wants another order.
std::optional<std::size_t> count_negative_eigenvalues(const TrianglePattern& upper, std::vector<double> values);

}  // namespace tanor
