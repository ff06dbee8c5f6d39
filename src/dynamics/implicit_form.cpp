#include "dynamics/implicit_form.hpp"

#include <algorithm>
#include <cmath>

#include "base/check.hpp"
#include "base/stopwatch.hpp"
#include "dynamics/normal_form.hpp"
#include "system/text.hpp"

namespace tanor {

namespace {

/// Springs, then rods.
std::vector<Coupling> list_couplings(const Model& model) {
  std::vector<Coupling> result = model.forces.list_couplings();
  const std::vector<Coupling> rods = model.constraints.list_rods();
  result.insert(result.end(), rods.begin(), rods.end());
  return result;
}

}  // namespace

std::unique_ptr<ImplicitEquations> NormalForm::make_implicit_equations() {
  ensure(friction_ == nullptr, "friction was refused before");
  return std::make_unique<ImplicitForm>(model_, lambda_);
}

ImplicitForm::ImplicitForm(Model& model, std::span<const double> multipliers)
    : model_(model),
      multipliers_(multipliers),
      num_springs_(model.forces.list_couplings().size()),
      plan_(std::span(model.mass).first(model.num_moving()), num_active_rows(), list_couplings(model),
            model.incidences),
      blocks_(3 * model.constraints.num_blocks()),
      blocks_at_newton_(blocks_.size()),
      reactions_(3 * model.num_points(), 0.0),
      product_(3 * model.num_moving()),
      point_positions_(model.num_moving()),
      point_velocities_(model.num_moving()),
      coupling_positions_(num_springs_ + model.constraints.list_rods().size()),
      coupling_velocities_(coupling_positions_.size()) {}

Outcome ImplicitForm::evaluate(double t, const double* r, const double* v, const double* lambda, double* w,
                               double* rates) {
  model_.set_time(t);
  ++model_.counters.evaluations;
  const Stopwatch watch(&model_.times.evaluate);
  double scale = model_.evaluate_free(t, r, v, w);
  scale = larger(scale, model_.constraints.evaluate_rates(model_.parallel, r, v, rates));
  if (!std::isfinite(scale)) return model_.not_finite(t);
  if (num_multipliers() == 0) return {};
  model_.constraints.evaluate_gradients(model_.parallel, r, blocks_.data());
  model_.gather.write_scaled(model_.parallel, blocks_.data(), lambda, model_.inverse_mass.data(), model_.num_moving(),
                             reactions_.data());
  // w = M^-1 (f + K lambda)
  model_.parallel.for_ranges(3 * model_.num_moving(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) w[i] += reactions_[i];
  });
  return {};
}

double ImplicitForm::evaluate_positions(double t, const double* r, double* xi) {
  model_.set_time(t);
  const Stopwatch watch(&model_.times.evaluate);
  return model_.constraints.evaluate_values(model_.parallel, r, xi);
}

double ImplicitForm::evaluate_rates(double t, const double* r, const double* v, double* rates) {
  model_.set_time(t);
  const Stopwatch watch(&model_.times.evaluate);
  return model_.constraints.evaluate_rates(model_.parallel, r, v, rates) / model_.velocity_scale;
}

Power ImplicitForm::power(const double* r, const double* v) const {
  return model_.power(reactions_.data(), r, v);
}

void ImplicitForm::linearise(double t, const double* r, const double* v, const double* lambda) {
  model_.set_time(t);
  linearised_at_ = t;
  const Stopwatch watch(&model_.times.evaluate);
  model_.constraints.evaluate_gradients(model_.parallel, r, blocks_at_newton_.data());
  model_.forces.evaluate_derivatives(model_.parallel, t, r, v,
                                     {point_positions_.data(), point_velocities_.data(), coupling_positions_.data(),
                                      coupling_velocities_.data()});
  model_.constraints.evaluate_rod_derivatives(model_.parallel, r, lambda, coupling_positions_.data() + num_springs_);
}

NewtonPlan::Values ImplicitForm::values() const {
  return {point_positions_.data(), point_velocities_.data(), coupling_positions_.data(), coupling_velocities_.data(),
          blocks_at_newton_.data()};
}

void ImplicitForm::add_stiffness(const double* dr, double* w) {
  std::fill(product_.begin(), product_.end(), 0.0);
  plan_.add_stiffness(values(), dr, product_.data());
  for (std::size_t i = 0; i < product_.size(); ++i) w[i] += model_.inverse_mass[i / 3] * product_[i];
}

template <class T>
Outcome ImplicitForm::factorize(const NewtonWeights<T>& weights, Factor<T>* factor) {
  if (plan_.rows().empty()) return {};
  if (factor->lu == nullptr) {
    factor->lu = std::make_unique<SparseLu<T>>(SquarePattern{plan_.column_start(), plan_.rows()});
    factor->unknowns.resize(factor->lu->pattern().size());
  }
  {
    const Stopwatch watch(&model_.times.assemble);
    plan_.assemble<T>({weights.mass, weights.velocity, weights.position}, values(), factor->lu->values());
  }
  const Stopwatch watch(&model_.times.factor);
  ++model_.counters.factorizations;
  if (factor->lu->factorize()) return {};
  return {Status::Singular, "Newton's matrix of the implicit step is singular at t = " + text(linearised_at_)};
}

template <class T>
void ImplicitForm::solve(Factor<T>* factor, T* y, T* mu) {
  const Stopwatch watch(&model_.times.solve);
  ++model_.counters.solves;
  const std::size_t moving = 3 * model_.num_moving(), rows = num_active_rows();
  std::vector<T>& unknowns = factor->unknowns;
  if (!unknowns.empty()) {
    for (std::size_t i = 0; i < moving; ++i) unknowns[i] = model_.mass[i / 3] * y[i];
    std::copy(mu, mu + rows, unknowns.begin() + static_cast<std::ptrdiff_t>(moving));
    factor->lu->solve(unknowns.data());
    std::copy_n(unknowns.begin(), moving, y);
    std::copy_n(unknowns.begin() + static_cast<std::ptrdiff_t>(moving), rows, mu);
  }
  std::fill(y + moving, y + 3 * model_.num_points(), T(0.0));
  std::fill(mu + rows, mu + num_multipliers(), T(0.0));
}

}  // namespace tanor
