#pragma once

#include <vector>

#include "dynamics/rank_revealing_factor.hpp"

namespace tanor::detail {

/// Corrects solutions where the contacts that stick are compliant. The factor P of S + C leaves a large error in
/// motions that the constraints hold no more stiffly than C does, e.g. of a bead between two others nearly on their
/// line. Repeated solves with P reduce that error by a tenth each time, or less. Generalized conjugate residuals
/// preconditioned by P (Eisenstat, Elman and Schultz 1983) never let the defect grow, even where rounding leaves it
/// outside the range of S.
class ConjugateResiduals {
 public:
  /// `blocks` is K, always at the present configuration.
  ConjugateResiduals(Workspace& work, RankRevealingFactor& factor, const std::vector<double>& blocks)
      : work_(work), model_(work.model()), factor_(factor), blocks_(blocks) {}

  /// Takes one step towards K'y + b = 0 from the defect rho = K'y + b in `rows`. Writes the increment of the
  /// multipliers into `rows` and adds M^-1 K rows to `points`. If `begins` is true, the earlier directions belong to
  /// another problem and are dropped.
  void correct(bool begins, double* rows, double* points);

 private:
  struct Direction {
    std::vector<double> d, q;  // [d] a direction of the multipliers, and S d
  };

  Workspace& work_;
  const Model& model_;
  RankRevealingFactor& factor_;
  const std::vector<double>& blocks_;
  std::vector<Direction> directions_;
  std::vector<double> y_;  // [3n]
  std::size_t num_kept_ = 0, next_ = 0;
};

}  // namespace tanor::detail
