#pragma once

#include "factor/sparse_qr.hpp"

namespace tanor::detail {

/// Does factorize_qr by SuiteSparseQR, which is GPL-2.0-or-later. It is part of the library if TANOR_GPL is on.
TriangularFactor factorize_with_suitesparse(const SparseColumns& C, double tolerance);

}  // namespace tanor::detail
