// RankSolver once more, under another name and on SuiteSparseQR.
#include "factor/suitesparse_qr.hpp"

#define RankSolver RankSolverOnSuiteSparse
#define factorize_qr factorize_with_suitesparse
#include "factor/rank_solver.cpp"
#include "suitesparse_rank_solver.hpp"

namespace tanor {

SuiteSparseRank find_rank_with_suitesparse(const SparseColumns& C) {
  const RankSolverOnSuiteSparse solver(C);
  return {solver.rank(), solver.dependences(), solver.unique()};
}

}  // namespace tanor
