#pragma once

#include <cstddef>
#include <vector>

#include "factor/rank_solver.hpp"

namespace tanor {

/// What RankSolver finds on the QR that the library was not built with: SuiteSparseQR, or fronts of our own.
struct OtherRank {
  std::size_t rank;
  std::vector<Dependence> dependences;
  std::vector<bool> unique;
};
OtherRank find_rank_on_other_qr(const SparseColumns& C);

}  // namespace tanor
