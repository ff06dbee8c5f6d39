#pragma once

#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor {

/// Residuals beside their own neighbourhood: one that is far, fast or heavy has no say about others. Each function asks
/// first what is cheap: what is little beside the slowest neighbourhood is little beside each.
class Residuals {
 public:
  /// `blocks`: K, always at the present configuration.
  Residuals(const Workspace& work, const std::vector<double>& blocks);

  /// What is solved for at the instant at hand: w0 = M^-1 f [3n], b = phi + K'w0 [d], and the largest of both, m/s^2.
  struct Problem {
    const double* w0;
    const double* b;
    double scale;
  };
  /// The next accelerations belong to another instant.
  void begin_instant() { knows_accelerations_ = false; }
  /// The largest |w0| and |b|/|gradient| of each neighbourhood, m/s^2: that of the first `problem` of an instant.
  const std::vector<double>& measure_accelerations(const Problem& problem);
  /// As they were measured last.
  const std::vector<double>& accelerations() const { return accelerations_; }

  /// Largest over the neighbourhoods of |K'w + phi|, `rows` [d], over their accelerations; `largest`: of all rows.
  double relative_residual(const Problem& problem, const std::vector<double>& rows, double largest);
  /// Largest over the neighbourhoods of |K'v + xi_t|, `rows` [d], over their speeds; `largest`: of all rows.
  double relative_rates(const std::vector<double>& rows, double largest);
  /// The largest |xi|/length of rows where it is more than `allowed` and than `times` the rounding of their positions,
  /// eps |r|/length; 0: there is none. `violation`: the largest of all rows.
  double beyond_rounding(const double* r, double violation, double allowed, double times);

 private:
  const std::vector<double>& gradient_norms();
  double rounding_floor(const double* r) const;

  const Workspace& work_;
  const Model& model_;
  const std::vector<double>& blocks_;
  std::vector<double> accelerations_;  // [neighbourhood] m/s^2
  bool knows_accelerations_ = false;   // of the instant at hand
  std::vector<double> norms_;          // [d] scratch
  struct {
    std::vector<double> places, at_rest, position, rates, lengths;
  } beyond_;  // scratch of `beyond_rounding`
};

}  // namespace tanor
