#pragma once

#include <vector>

#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Measures residuals by the scale of their own neighbourhood, so that one that is far, fast or heavy does not decide
/// for others. Each function tries a cheap test first: a residual that is small beside the slowest neighbourhood is
/// small beside each.
class Residuals {
 public:
  /// `blocks` is K, always at the present configuration.
  Residuals(const Workspace& work, const std::vector<double>& blocks);

  /// The problem at the present instant: w0 = M^-1 f [3n], b = phi + K'w0 [d], and the largest of both, m/s^2.
  struct Problem {
    const double* w0;
    const double* b;
    double scale;
  };
  /// Begins another instant, so that accelerations are measured again.
  void begin_instant() { knows_accelerations_ = false; }
  /// Returns the largest |w0| and |b|/|gradient| of each neighbourhood, m/s^2, of the first `problem` of an instant.
  const std::vector<double>& measure_accelerations(const Problem& problem);
  /// The accelerations that were measured last.
  const std::vector<double>& accelerations() const { return accelerations_; }

  /// Returns the largest ratio of |K'w + phi|, `rows` [d], to the accelerations of its neighbourhood. `largest` is that
  /// of all rows.
  double relative_residual(const Problem& problem, const std::vector<double>& rows, double largest);
  /// Returns true if |K'w + phi| = |K'dw + b|, `rows` [d], is the rounding of its own terms in every row: at most 2 eps
  /// (|K'||dw| + |b|), which no refinement makes less (W. Oettli, W. Prager 1964; M. Arioli, J. W. Demmel, I. S. Duff,
  /// SIAM J. Matrix Anal. Appl. 10, 1989).
  bool are_rounding(const Problem& problem, const std::vector<double>& rows, const double* dw);
  /// Returns the largest ratio of |K'v + xi_t|, `rows` [d], to the speed of its neighbourhood. `largest` is that of all
  /// rows.
  double relative_rates(const std::vector<double>& rows, double largest);
  /// Returns the largest |xi|/|gradient|/length among the rows where it exceeds both `allowed` and `times` the rounding
  /// of their positions, eps |r|/length, or 0 if there is none. `xi` [d] is that at r, and `violation` the largest of
  /// all rows.
  double beyond_rounding(const double* r, const double* xi, double violation, double allowed, double times);

 private:
  const std::vector<double>& gradient_norms();
  double rounding_floor(const double* r) const;
  void find_lengths();
  bool has_rod_beyond(const double* xi, double allowed, double times) const;
  double largest_beyond(const double* r, double allowed, double times);

  const Workspace& work_;
  const Model& model_;
  const std::vector<double>& blocks_;
  std::vector<double> terms_;  // [d]
  const bool all_are_rods_;
  std::vector<double> accelerations_;  // [neighbourhood] m/s^2
  bool knows_accelerations_ = false;   // true if they belong to the present instant
  std::vector<double> norms_;          // [d] scratch
  struct {
    std::vector<double> places, at_rest, position, rates, lengths;
  } beyond_;  // scratch of `beyond_rounding`
};

}  // namespace tanor::detail
