#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/stopwatch.hpp"
#include "dynamics/normal_form.hpp"

/// \file NormalForm on the composite of Schur solvers, where they serve all islands; what they cannot decide is left to
/// the sparse factor of all.
namespace tanor {

/// All of it by the composite, with K evaluated or kept. None where S looks singular, or K'w = -phi does not come out:
/// the general way decides.
std::optional<Outcome> NormalForm::solve_schur(double t, const double* r, const double* v, Gradients gradients,
                                               double* w) {
  const bool keeps = gradients == Gradients::Keep;
  const Vec3* const uniform = model_.uniform_free();
  double scale = 0.0;
  {
    const Stopwatch watch(&model_.times.evaluate);
    scale = uniform != nullptr ? model_.write_unconstrained(w) : model_.evaluate_free(t, r, v, w);
  }
  Elimination found;
  {
    const Stopwatch watch(&model_.times.solve);
    if (!keeps && (!is_factorized_ || !model_.constraints.gradients_are_constant())) ++model_.counters.factorizations;
    ++model_.counters.solves;
    const FreeMotion motion{r, v, w, uniform};
    double *const blocks = blocks_.data(), *const b = right_side_.data(), *const lambda = lambda_.data();
    found = keeps ? schur_->solve_again(model_.parallel, motion, blocks, b, lambda, w)
                  : schur_->solve(model_.parallel, motion, blocks, b, lambda, w);
  }
  scale = larger(scale, found.largest_right_side);
  knows_accelerations_ = false;
  if (!keeps) last_.reciprocal_condition = found.reciprocal_condition;
  last_.residual = 0.0;
  last_.refinements = found.refinements;
  model_.counters.solves += static_cast<std::size_t>(found.refinements);
  if (!std::isfinite(scale)) return model_.not_finite(t);
  is_of_schur_ = is_factorized_ = last_.reciprocal_condition > suspect_below_;
  if (!is_of_schur_) return {};
  last_.residual = found.residual / (scale > 0.0 ? scale : 1.0);
  // Little beside each island, or beside the slowest neighbourhood, is little beside each neighbourhood.
  constexpr double little = 1e-12;
  const Scales& scales = model_.scales;
  const bool is_little =
      scales.are_one() || found.own_residual <= little || found.residual <= little * scales.least_acceleration();
  const bool is_fine = last_.residual <= good_enough() && is_little;
  if (is_fine && !model_.is_rheonomic()) return Outcome{};

  // Refinement wants w0 and dw apart, and so does the power of the reactions.
  model_.gather.write_scaled(model_.parallel, blocks_.data(), lambda_.data(), model_.inverse_mass.data(),
                             model_.num_moving(), dw_.data());
  if (is_fine) return Outcome{};
  (void)model_.evaluate_free(t, r, v, w);
  w0_ = w;
  (void)model_.constraints.evaluate_right_side(model_.parallel, r, v, w, right_side_.data(), nullptr);
  const double left_over = refine(scale);
  last_.refinements = std::max(last_.refinements, found.refinements);
  if (!(left_over <= doubtful_above)) {
    if (!keeps) is_of_schur_ = is_factorized_ = false;
    return {};
  }
  add_reactions(w);
  return Outcome{};
}

/// Factorizes S of the blocks at hand by the composite. False where it looks singular: for the general way to decide.
bool NormalForm::factorize_schur() {
  const Stopwatch watch(&model_.times.factor);
  ++model_.counters.factorizations;
  last_.reciprocal_condition = schur_->factorize(model_.parallel, blocks_.data()).reciprocal_condition;
  return is_of_schur_ = is_factorized_ = last_.reciprocal_condition > suspect_below_;
}

/// The same with K at r.
bool NormalForm::linearise_schur(const double* r) {
  const Stopwatch watch(&model_.times.factor);
  ++model_.counters.factorizations;
  last_.reciprocal_condition = schur_->linearise(model_.parallel, r, blocks_.data()).reciprocal_condition;
  return is_of_schur_ = is_factorized_ = last_.reciprocal_condition > suspect_below_;
}

/// As far as chord iterations lead, each island by itself; `sum` is a guess on entry.
void NormalForm::project_islands(double target, double* r, double* sum, ProjectionReport* report) {
  const Stopwatch watch(&model_.times.solve);
  const Projection found = schur_->project_positions(model_.parallel, blocks_.data(), target, r, sum);
  model_.counters.solves += static_cast<std::size_t>(found.iterations);
  report->iterations = found.iterations;
  report->violation = found.violation;
}

void NormalForm::project_island_velocities(double target, const double* r, double* v, ProjectionReport* report) {
  const Stopwatch watch(&model_.times.solve);
  const double speed = model_.scales.least_speed(), wanted = target * speed;
  const Projection found = schur_->project_velocities(model_.parallel, blocks_.data(), wanted, r, v);
  model_.counters.solves += static_cast<std::size_t>(found.iterations);
  report->iterations = found.iterations;
  report->violation = found.violation / speed;
}

/// xi into `rows_`; returns the largest |xi|/length.
double NormalForm::evaluate_values(const double* r) {
  const Stopwatch watch(&model_.times.evaluate);
  if (schur_ != nullptr) return schur_->evaluate_values(model_.parallel, r, rows_.data());
  const double largest = model_.constraints.evaluate_values(model_.parallel, r, rows_.data());
  return contacts_ != nullptr ? larger(largest, contacts_->held_violation(rows_.data())) : largest;
}

/// K'v + xi_t into `rows_`; returns the largest one, m/s.
double NormalForm::evaluate_rates(const double* r, const double* v) {
  const Stopwatch watch(&model_.times.evaluate);
  return schur_ != nullptr ? schur_->evaluate_rates(model_.parallel, r, v, rows_.data())
                           : model_.constraints.evaluate_rates(model_.parallel, r, v, rows_.data());
}

/// The composite has no matrix: largest eigenvalues of D S D and of its inverse by iteration, D = diag(S)^-1/2.
double NormalForm::estimate_reciprocal_condition() {
  if (!is_of_schur_) return general().estimate_reciprocal_condition();
  constexpr int iterations = 4;
  std::vector<double> scale(num_rows(), 0.0), x(num_rows()), dw(size(), 0.0);
  for (const auto& [point, row, block, sign] : model_.incidences) {
    const Vec3 g = load(blocks_.data(), block);
    scale[static_cast<std::size_t>(row)] += model_.inverse_mass[static_cast<std::size_t>(point)] * dot(g, g);
  }
  for (double& each : scale) each = std::sqrt(each);
  const auto find_largest = [&](const auto& apply) {
    double eigenvalue = 1.0;
    for (std::size_t a = 0; a < x.size(); ++a) x[a] = std::sin(1.0 + 2.399963 * static_cast<double>(a));
    for (int k = 0; k <= iterations; ++k) {
      eigenvalue = std::sqrt(std::inner_product(x.begin(), x.end(), x.begin(), 0.0));
      for (double& each : x) each /= eigenvalue;
      apply();
    }
    return eigenvalue;
  };
  const double largest = find_largest([&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
    model_.gather.write_scaled(model_.parallel, blocks_.data(), x.data(), model_.inverse_mass.data(),
                               model_.num_moving(), dw.data());
    model_.constraints.apply_transposed(model_.parallel, blocks_.data(), dw.data(), nullptr, x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] /= scale[a];
  });
  const double largest_of_inverse = find_largest([&] {
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
    schur_->solve_negative(model_.parallel, x.data(), x.data());
    for (std::size_t a = 0; a < x.size(); ++a) x[a] *= scale[a];
  });
  return 1.0 / (largest * largest_of_inverse);
}

}  // namespace tanor
