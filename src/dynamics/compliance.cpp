#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/stopwatch.hpp"
#include "dynamics/normal_form.hpp"

/// \file Corrections where contacts that stick are compliant. The factor P of S + C leaves over what constraints hold
/// no more stiffly than C: a bead between two others, nearly on their line. To repeat P alone wins a tenth of it each
/// time, or less.
namespace tanor {

namespace {

double product(const std::vector<double>& a, const double* b) {
  return std::inner_product(a.begin(), a.end(), b, 0.0);
}

}  // namespace

/// One step towards K'y + b = 0: rows := what is added to the multipliers, points += M^-1 K rows; `rows` holds the
/// defect rho = K'y + b. Generalized conjugate residuals with P in front (Eisenstat, Elman and Schultz 1983): the
/// defect never grows, also where rounding leaves it outside the range of S. With a factor that is not compliant:
/// `correct`.
void NormalForm::correct_conjugately(bool begins, double* rows, double* points) {
  if (!is_compliant()) return correct(rows, points);
  const Stopwatch watch(&model_.times.solve);
  ++model_.counters.solves;
  constexpr std::size_t most_kept = 12;
  auto& [directions, y, num_kept, next] = conjugate_;
  directions.resize(most_kept);
  for (Direction& each : directions) {
    each.d.resize(num_rows());
    each.q.resize(num_rows());
  }
  y.resize(size());
  if (begins) num_kept = next = 0;
  auto& [d, q] = directions[next];
  // d = -P^-1 rho, q = S d
  solve_negative(rows, d.data());
  model_.gather.write_scaled(model_.parallel, blocks_.data(), d.data(), model_.inverse_mass.data(), model_.num_moving(),
                             y.data());
  model_.constraints.apply_transposed(model_.parallel, blocks_.data(), y.data(), nullptr, q.data());
  // … less what earlier directions do, which are orthogonal and of length 1 in q.
  for (std::size_t k = 0; k < num_kept; ++k) {
    if (k == next) continue;
    const double share = product(q, directions[k].q.data());
    for (std::size_t a = 0; a < num_rows(); ++a) {
      d[a] -= share * directions[k].d[a];
      q[a] -= share * directions[k].q[a];
    }
  }
  const double length = std::sqrt(product(q, q.data())),
               defect = std::sqrt(std::inner_product(rows, rows + num_rows(), rows, 0.0));
  // What answers less than this has no stiffness but rounding: beads on one line, where K loses rank.
  constexpr double softest = 1e-6;
  if (!(length > softest * defect)) return std::fill(rows, rows + num_rows(), 0.0);
  for (std::size_t a = 0; a < num_rows(); ++a) {
    d[a] /= length;
    q[a] /= length;
  }
  const double alpha = -product(q, rows);
  for (std::size_t a = 0; a < num_rows(); ++a) rows[a] = alpha * d[a];
  model_.gather.add_scaled(model_.parallel, blocks_.data(), rows, model_.inverse_mass.data(), model_.num_moving(),
                           points);
  next = (next + 1) % most_kept;
  num_kept = std::max(num_kept, next == 0 ? most_kept : next);
}

}  // namespace tanor
