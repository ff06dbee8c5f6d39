#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <utility>

#include "dynamics/implicit_equations.hpp"
#include "ranks/agreement.hpp"
#include "ranks/shared_mechanics.hpp"

namespace tanor::detail {

/// The implicit equations of whole islands, of which every rank has its own. Newton's matrix of all is a block for each
/// rank, which factorizes and solves that alone; outcomes, the largest violation and powers are those of all ranks.
class SharedImplicitEquations final : public ImplicitEquations {
 public:
  /// `ranks` outlive it.
  SharedImplicitEquations(std::unique_ptr<ImplicitEquations> own, Ranks& ranks)
      : own_(std::move(own)), ranks_(ranks), agreement_(ranks) {}

  std::size_t num_constraints() const override { return own_->num_constraints(); }
  std::size_t num_rows() const override { return own_->num_rows(); }
  void write_multipliers(const Reactions& found, const double* x, const double* v, double* lambda) override {
    own_->write_multipliers(found, x, v, lambda);
  }

  Outcome evaluate(double t, const double* x, const double* v, const double* lambda, double* a, double* rows,
                   Power* power) override {
    Outcome found = agreement_.together([&] { return own_->evaluate(t, x, v, lambda, a, rows, power); });
    if (found.ok() && power != nullptr) *power = sum_powers(ranks_, *power);
    return found;
  }
  double evaluate_positions(double t, const double* x, double* xi) override {
    double violation = 0.0;
    (void)agreement_.together(
        [&] {
          violation = own_->evaluate_positions(t, x, xi);
          return Outcome{};
        },
        {&violation, 1});
    return violation;
  }
  void linearise(double t, const double* x, const double* v, const double* lambda) override {
    (void)agreement_.together([&] {
      own_->linearise(t, x, v, lambda);
      return Outcome{};
    });
  }
  void add_stiffness(const double* dx, double* a, double* rows) override { own_->add_stiffness(dx, a, rows); }
  Outcome factorize(const NewtonWeights<double>& weights) override {
    return agreement_.together([&] { return own_->factorize(weights); });
  }
  Outcome factorize(const NewtonWeights<std::complex<double>>& weights) override {
    return agreement_.together([&] { return own_->factorize(weights); });
  }
  void solve(double* a, double* rows) override { own_->solve(a, rows); }
  void solve(std::complex<double>* a, std::complex<double>* rows) override { own_->solve(a, rows); }
  void exchange_memory(Memory& memory) override { own_->exchange_memory(memory); }

 private:
  std::unique_ptr<ImplicitEquations> own_;
  Ranks& ranks_;
  Agreement agreement_;
};

}  // namespace tanor::detail
