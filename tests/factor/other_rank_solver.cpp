#include "factor/multifrontal_qr.hpp"
#include "factor/suitesparse_qr.hpp"

// RankSolver once more, under another name and on the other QR.
#define RankSolver RankSolverOnOtherQr
#if TANOR_GPL
#define factorize_qr factorize_by_fronts
#else
#define factorize_qr factorize_with_suitesparse
#endif
#include "factor/rank_solver.cpp"
#include "other_rank_solver.hpp"

namespace tanor {

OtherRank find_rank_on_other_qr(const SparseColumns& C) {
  const RankSolverOnOtherQr solver(C);
  return {solver.rank(), solver.dependences(), solver.unique()};
}

}  // namespace tanor
