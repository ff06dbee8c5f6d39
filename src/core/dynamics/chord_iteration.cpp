#include "dynamics/chord_iteration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

/// The progress of a chord iteration.
struct ChordProgress {
  static constexpr double infinity = std::numeric_limits<double>::infinity();

  ChordEquations& equations;
  double before = infinity, left_before = infinity;  // the last violation; its part above rounding
  bool stalls = false, stands = false;               // the violation hardly falls; it does not fall at all
  bool linearised_here = false, decided_here = false;

  /// Compares a violation with that of the iteration before. Returns true if only rounding is left of it.
  bool is_rounding(const double* r, double violation, double target) {
    stalls = violation > 0.3 * before;
    stands = violation > 0.99 * before;
    if (!stalls) return false;
    // One neighbourhood may have reached its rounding while others still converge.
    const double left = equations.beyond_rounding(r, violation, target, 1.0);
    if (left == 0.0) return true;
    stalls = left > 0.3 * left_before || left == violation;
    stands = stalls && left > 0.99 * std::min(before, left_before);
    left_before = left;
    return false;
  }

  /// Returns true if rows have become independent. The rank is decided once at most.
  bool decide_rank_again(const double* r) {
    if (decided_here) return false;
    decided_here = true;
    before = left_before = infinity;
    return equations.decide_rank_again(r);
  }
};

}  // namespace

ProjectionReport project_along_chord(const Model& model, ChordEquations& equations, const ChordLimits& limits, double t,
                                     double* r, double* sum, ProjectionReport report) {
  constexpr int most_iterations = 100;
  for (ChordProgress progress{equations};; ++report.iterations) {
    report.violation = equations.evaluate_values(r);
    if (!std::isfinite(report.violation)) {
      report.outcome = model.not_finite(t);
      return report;
    }
    if (report.violation <= limits.target || progress.is_rounding(r, report.violation, limits.target)) return report;
    const bool hopeless = progress.stands && (progress.linearised_here || sum != nullptr);
    if (report.iterations == most_iterations || hopeless) {
      const double left_over = equations.beyond_rounding(r, report.violation, limits.largest_left, 2.0);
      if (left_over > 0.0 && sum == nullptr && progress.decide_rank_again(r)) continue;
      if (left_over > 0.0) report.outcome = equations.explain_stall(t, report.violation);
      return report;
    }
    const bool is_far = report.iterations == 0 && report.violation > limits.far;
    if ((progress.stalls || is_far) && sum == nullptr) {
      // The slope of the chord is too old, so K is evaluated here.
      if (report.outcome = equations.linearise_at(t, r); !report.outcome.ok()) return report;
      progress.linearised_here = true;
    }
    progress.before = report.violation;
    equations.correct_positions(r, sum);
  }
}

}  // namespace tanor::detail
