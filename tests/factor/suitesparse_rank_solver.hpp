#pragma once

#include <vector>

#include "factor/rank_solver.hpp"

namespace tanor {

/// What RankSolver finds with SuiteSparseQR, whichever QR the library was built with.
struct SuiteSparseRank {
  std::size_t rank;
  std::vector<Dependence> dependences;
  std::vector<bool> unique;
};
SuiteSparseRank find_rank_with_suitesparse(const SparseColumns& C);

}  // namespace tanor
