#include "dynamics/conjugate_residuals.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/stopwatch.hpp"

namespace tanor::detail {

namespace {

double product(const std::vector<double>& a, const double* b) {
  return std::inner_product(a.begin(), a.end(), b, 0.0);
}

}  // namespace

void ConjugateResiduals::correct(bool begins, double* rows, double* points) {
  const Stopwatch watch(&work_.times.solve);
  ++work_.counters.solves;
  constexpr std::size_t most_kept = 12;
  const std::size_t num_rows = model_.num_rows();
  directions_.resize(most_kept);
  for (Direction& each : directions_) {
    each.d.resize(num_rows);
    each.q.resize(num_rows);
  }
  y_.resize(3 * model_.num_points());
  if (begins) num_kept_ = next_ = 0;
  auto& [d, q] = directions_[next_];
  // d = -P^-1 rho, q = S d
  factor_.solve_negative(model_.parallel, rows, d.data());
  model_.gather.write_scaled(model_.parallel, blocks_.data(), d.data(), model_.inverse_mass.data(), model_.num_moving(),
                             y_.data());
  work_.constraints.apply_transposed(model_.parallel, blocks_.data(), y_.data(), nullptr, q.data());
  // Orthogonalize against the earlier directions, whose q are orthonormal.
  for (std::size_t k = 0; k < num_kept_; ++k) {
    if (k == next_) continue;
    const double share = product(q, directions_[k].q.data());
    for (std::size_t a = 0; a < num_rows; ++a) {
      d[a] -= share * directions_[k].d[a];
      q[a] -= share * directions_[k].q[a];
    }
  }
  const double length = std::sqrt(product(q, q.data())),
               defect = std::sqrt(std::inner_product(rows, rows + num_rows, rows, 0.0));
  // A direction with a smaller response has no stiffness but rounding, e.g. beads on one line, where K loses rank.
  constexpr double softest = 1e-6;
  if (!(length > softest * defect)) return std::fill(rows, rows + num_rows, 0.0);
  for (std::size_t a = 0; a < num_rows; ++a) {
    d[a] /= length;
    q[a] /= length;
  }
  const double alpha = -product(q, rows);
  for (std::size_t a = 0; a < num_rows; ++a) rows[a] = alpha * d[a];
  factor_.add_reactions(model_.parallel, blocks_.data(), rows, points);
  next_ = (next_ + 1) % most_kept;
  num_kept_ = std::max(num_kept_, next_ == 0 ? most_kept : next_);
}

}  // namespace tanor::detail
