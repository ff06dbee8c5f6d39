#pragma once

#include <vector>

#include "dynamics/rank_revealing_factor.hpp"

namespace tanor {

/// Corrections where contacts that stick are compliant. The factor P of S + C leaves over what constraints hold no more
/// stiffly than C: a bead between two others, nearly on their line. To repeat P alone wins a tenth of it each time, or
/// less. Generalized conjugate residuals with P in front (Eisenstat, Elman and Schultz 1983) never let the defect grow,
/// also where rounding leaves it outside the range of S.
class ConjugateResiduals {
 public:
  /// `blocks`: K, always at the present configuration.
  ConjugateResiduals(Workspace& work, RankRevealingFactor& factor, const std::vector<double>& blocks)
      : work_(work), model_(work.model()), factor_(factor), blocks_(blocks) {}

  /// One step towards K'y + b = 0 from the defect rho = K'y + b in `rows`: rows := what is added to the multipliers,
  /// points += M^-1 K rows. `begins`: earlier directions belong to something else.
  void correct(bool begins, double* rows, double* points);

 private:
  struct Direction {
    std::vector<double> d, q;  // [d] of multipliers, and S d
  };

  Workspace& work_;
  const Model& model_;
  RankRevealingFactor& factor_;
  const std::vector<double>& blocks_;
  std::vector<Direction> directions_;
  std::vector<double> y_;  // [3n]
  std::size_t num_kept_ = 0, next_ = 0;
};

}  // namespace tanor
