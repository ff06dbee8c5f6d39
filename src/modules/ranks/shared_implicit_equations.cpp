#include "ranks/shared_implicit_equations.hpp"

#include <array>

#include "ranks/shared_mechanics.hpp"

namespace tanor::detail {

Outcome SharedImplicitEquations::evaluate(double t, const double* x, const double* v, const double* lambda, double* a,
                                          double* rows, Power* power) {
  Outcome found = agreement_.together([&] { return own_->evaluate(t, x, v, lambda, a, rows, power); });
  if (found.ok() && power != nullptr) *power = sum_powers(ranks_, *power);
  return found;
}

double SharedImplicitEquations::evaluate_positions(double t, const double* x, double* xi) {
  std::array<double, 1> violation{};
  (void)agreement_.together(
      [&] {
        violation[0] = own_->evaluate_positions(t, x, xi);
        return Outcome{};
      },
      violation);
  return violation[0];
}

void SharedImplicitEquations::linearise(double t, const double* x, const double* v, const double* lambda) {
  (void)agreement_.together([&] {
    own_->linearise(t, x, v, lambda);
    return Outcome{};
  });
}

}  // namespace tanor::detail
