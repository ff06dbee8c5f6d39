#include "statics/equilibrium_equations.hpp"

#include <algorithm>
#include <cmath>

#include "base/numbers.hpp"

namespace tanor {

namespace {

constexpr double step_of_irregular = 2.3;

}  // namespace

EquilibriumEquations::EquilibriumEquations(Workspace& work, double t, Vec3 spin)
    : work_(work),
      model_(work.model()),
      t_(t),
      extent_(model_.scene_size),
      spin_(spin),
      stiffness_(work),
      rounding_(model_.num_moving(), 0.0),
      blur_(model_.num_moving(), 0.0),
      blocks_(3 * work.constraints.num_blocks()),
      f_(3 * model_.num_points()),
      reactions_(3 * model_.num_points()),
      at_rest_(3 * model_.num_points(), 0.0) {}

double EquilibriumEquations::evaluate(const double* r, const double* lambda, double* g, double* xi) {
  work_.set_time(t_);
  const Parallel& parallel = model_.parallel;
  ++work_.counters.evaluations;
  work_.forces.evaluate(parallel, t_, r, at_rest_.data(), f_.data());
  violation_ = work_.constraints.evaluate_values(parallel, r, xi);
  extent_ = std::max(model_.scene_size, model_.largest_norm(r));
  work_.constraints.evaluate_gradients(parallel, r, blocks_.data());
  // g = f + K lambda
  model_.gather.reactions(parallel, blocks_.data(), lambda, reactions_.data());
  double largest = larger(work_.forces.largest_single(parallel, r), std::isfinite(violation_) ? 0.0 : violation_);
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const Vec3 force = load(f_.data(), i), sum = force + load(reactions_.data(), i);
    store(g, i, sum);
    largest = larger(largest, norm(force));
    largest = larger(largest, 0.0 * norm(sum));  // is NaN where a reaction is
  }
  for (const Incidence& incidence : model_.incidences) {
    if (static_cast<std::size_t>(incidence.point) < model_.num_moving())
      largest = larger(largest, std::abs(lambda[incidence.row]) * norm(load(blocks_.data(), incidence.block)));
  }
  return largest;
}

void EquilibriumEquations::linearise(const double* r, const double* lambda, StiffnessMatrix::Curvature curvature) {
  work_.set_time(t_);
  work_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  stiffness_.evaluate(t_, r, lambda, curvature);
  for (std::size_t i = 0; i < rounding_.size(); ++i)
    rounding_[i] = 64.0 * eps * stiffness_.largest_of(i) * std::max(model_.scene_size, norm(load(r, i)));
  std::ranges::fill(blur_, 0.0);
}

void EquilibriumEquations::linearise_near(const double* r, const double* lambda, double error) {
  if (error == 0.0) return linearise(r, lambda);
  std::vector<double> near(r, r + 3 * model_.num_points());
  disturb(error, near.data());
  linearise(near.data(), lambda);
  const std::vector<double> there = stiffness_.sum_rows();
  linearise(r, lambda);
  const std::vector<double> here = stiffness_.sum_rows();
  for (std::size_t i = 0; i < blur_.size(); ++i) blur_[i] = std::abs(there[i] - here[i]);
}

void EquilibriumEquations::disturb(double by, double* r) const {
  for (std::size_t i = 0; i < size(); ++i) r[i] += by * irregular(i, step_of_irregular);
}

void EquilibriumEquations::add_reactions(const double* lambda, double* y) const {
  std::vector<double> all(3 * model_.num_points());
  model_.gather.reactions(model_.parallel, blocks_.data(), lambda, all.data());
  for (std::size_t i = 0; i < size(); ++i) y[i] += all[i];
}

void EquilibriumEquations::apply_transposed(const double* x, double* rows) const {
  std::vector<double> all(3 * model_.num_points(), 0.0);  // supports do not move
  std::copy_n(x, size(), all.begin());
  work_.constraints.apply_transposed(model_.parallel, blocks_.data(), all.data(), nullptr, rows);
}

}  // namespace tanor
