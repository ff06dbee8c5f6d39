#pragma once

#include "factor/sparse_qr.hpp"

namespace tanor {

/// factorize_qr by SuiteSparseQR, which is GPL-2.0-or-later: part of the library where TANOR_GPL is on.
TriangularFactor factorize_with_suitesparse(const SparseColumns& C, double tolerance);

}  // namespace tanor
