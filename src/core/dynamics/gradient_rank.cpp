#include "dynamics/gradient_rank.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"
#include "base/stopwatch.hpp"

namespace tanor::detail {

void GradientRank::remember_gradients() {
  if (work_.team().is_alone() && !linearization_.dependences().is_found())
    before_ = linearization_.blocks();
  else
    before_.clear();
  openings_ = work_.constraints.open.num_changes();
}

/// With K_0 before and K_1 now, C = S_1^-1 K_1'M^-1 K_0 is the identity if nothing turns. A singular value that went
/// from s_0 to s_1 is an eigenvalue s_0/s_1 of C. The largest eigenvalue of 1 - C is found by power iteration.
double GradientRank::compare_gradients() {
  if (before_.empty() || openings_ != work_.constraints.open.num_changes()) return 1.0;
  if (linearization_.dependences().is_found() || linearization_.shares_loads()) return 0.0;
  const Stopwatch watch(&work_.times.solve);
  constexpr int most_iterations = 10, least_iterations = 4;
  constexpr double hopeless = 0.7;
  work_.constraints.turn_frames(linearization_.blocks().data(), before_.data());
  x_.resize(model_.num_rows());
  y_.resize(model_.num_rows());
  move_.assign(3 * model_.num_points(), 0.0);
  // Rows without a gradient (of contacts that slide, of supports alone) do not turn. C is 0 there, and their eigenvalue
  // 1 of 1 - C would hide the others.
  std::fill(x_.begin(), x_.end(), 0.0);
  for (const Incidence& incidence : model_.incidences) {
    const bool moves = model_.inverse_mass[static_cast<std::size_t>(incidence.point)] > 0.0;
    const auto a = static_cast<std::size_t>(incidence.row);
    if (moves && x_[a] == 0.0 && norm(load(before_.data(), incidence.block)) > 0.0) x_[a] = irregular(a);
  }
  double eigenvalue = 0.0;  // of 1 - C
  for (int k = 0; k < most_iterations; ++k) {
    model_.gather.write_scaled(model_.parallel, before_.data(), x_.data(), model_.inverse_mass.data(),
                               model_.num_moving(), move_.data());
    linearization_.apply_transposed(move_.data(), nullptr, y_.data());
    ++work_.counters.solves;
    linearization_.solve_negative(y_.data(), y_.data());
    double along = 0.0, before = 0.0, after = 0.0;
    for (std::size_t a = 0; a < x_.size(); ++a) {
      y_[a] += x_[a];
      along += x_[a] * y_[a];
      before += x_[a] * x_[a];
      after += y_[a] * y_[a];
    }
    eigenvalue = along / before;
    if (!(after > 0.0) || (k >= least_iterations && after < hopeless * hopeless * before)) break;
    for (std::size_t a = 0; a < x_.size(); ++a) x_[a] = y_[a] / std::sqrt(after);
  }
  return 1.0 / (1.0 - eigenvalue);
}

}  // namespace tanor::detail
