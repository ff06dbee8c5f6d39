#include "motion/implicit_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/check.hpp"
#include "base/numbers.hpp"

namespace tanor::detail {

namespace {

std::unique_ptr<ImplicitEquations> make_equations(Mechanics& mechanics) {
  ImplicitFormulation* const formulation = mechanics.implicit_formulation();
  ensure(formulation != nullptr, "implicit methods step in normal form, with no friction but viscous");
  std::unique_ptr<ImplicitEquations> equations;
  (void)mechanics.together([&] {
    equations = formulation->make_implicit_equations();
    return Outcome{};
  });
  return equations;
}

}  // namespace

ImplicitStep::ImplicitStep(const IntegrationOptions& options, Mechanics& given)
    : mechanics(given),
      equations(make_equations(given)),
      newton(options.rtol),
      options_(options),
      moves_(given.size()),
      rates_(given.size()),
      rows_(equations->num_rows()) {}

void ImplicitStep::linearise(double t, const double* x, const double* v, const double* lambda) {
  (void)mechanics.together([&] {
    equations->linearise(t, x, v, lambda);
    return Outcome{};
  });
  renew_ = false;
  forget_factors();
}

Outcome ImplicitStep::evaluate(double t, const double* x, const double* v, const double* lambda, double* a,
                               double* rows, Power* power) {
  Outcome found = mechanics.together([&] { return equations->evaluate(t, x, v, lambda, a, rows, power); });
  if (found.ok() && power != nullptr) *power = mechanics.sum(*power);
  return found;
}

double ImplicitStep::evaluate_positions(double t, const double* x, double* xi) {
  double violation = 0.0;
  (void)mechanics.together(
      [&] {
        violation = equations->evaluate_positions(t, x, xi);
        return Outcome{};
      },
      {&violation, 1});
  return violation;
}

bool ImplicitStep::wants_factors(const State& from, double h) {
  constexpr double same = 0.01;  // relative difference up to which lengths count as equal
  const bool wants = !(std::abs(factorized_for_ - h) <= same * h);
  if (wants) factorized_for_ = h;
  newton.begin(!wants, measure_rounding(from));
  return wants;
}

/// Returns the size of eps |x| and eps |v| over the tolerance.
double ImplicitStep::measure_rounding(const State& at) {
  for (std::size_t i = 0; i < moves_.size(); ++i) {
    moves_[i] = eps * at.x[i];
    rates_[i] = eps * at.v[i];
  }
  const double *const x = at.x.data(), *const v = at.v.data();
  return mechanics.error_ratios(at.t, {moves_.data(), rates_.data(), x, v, x, v}, options_.atol, options_.rtol)
      .largest();
}

void ImplicitStep::note_convergence() {
  constexpr double slow = 0.05;
  renew_ = newton.rate() > slow;
}

StepResult ImplicitStep::finish(State* to, MovedVelocity moved_velocity) {
  mechanics.prescribe(to->t, to->x.data(), to->v.data());
  if (options_.stabilisation == Stabilisation::Projection) put_onto_positions(to);
  return stabilize(mechanics, options_, to, moved_velocity);
}

/// Projects positions by chord iterations N dx = K mu, K'dx = -xi, with the K of the linearisation. All ranks take
/// part, also one without constraints.
void ImplicitStep::put_onto_positions(State* to) {
  constexpr double target = 1e-13;
  constexpr int most_iterations = 10;
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most_iterations; ++k) {
    const double violation = evaluate_positions(to->t, to->x.data(), rows_.data());
    if (!(violation > target) || !(violation < 0.5 * before)) return;
    before = violation;
    std::fill(moves_.begin(), moves_.end(), 0.0);
    std::fill(rows_.begin() + static_cast<std::ptrdiff_t>(equations->num_constraints()), rows_.end(), 0.0);
    equations->solve(moves_.data(), rows_.data());
    for (std::size_t i = 0; i < moves_.size(); ++i) to->x[i] += moves_[i];
  }
}

}  // namespace tanor::detail
