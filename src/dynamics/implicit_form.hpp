#pragma once

#include <array>
#include <complex>
#include <vector>

#include "assembly/newton_plan.hpp"
#include "dynamics/mechanics.hpp"
#include "dynamics/model.hpp"
#include "factor/sparse_lu.hpp"

namespace tanor {

/// The equations of the normal form as implicit schemes want them; without friction.
class ImplicitForm final : public ImplicitEquations {
 public:
  /// `multipliers`: of the last accelerations, kept by whoever computes them.
  ImplicitForm(Model& model, std::span<const double> multipliers);

  std::size_t num_multipliers() const override { return model_.num_rows(); }
  std::span<const double> multipliers() const override { return multipliers_; }

  Outcome evaluate(double t, const double* r, const double* v, const double* lambda, double* w,
                   double* rates) override;
  double evaluate_positions(double t, const double* r, double* xi) override;
  double evaluate_rates(double t, const double* r, const double* v, double* rates) override;
  Power power(const double* r, const double* v) const override;

  void linearise(double t, const double* r, const double* v, const double* lambda) override;
  void add_stiffness(const double* dr, double* w) override;
  Outcome factorize(const NewtonWeights<double>& weights) override { return factorize(weights, &real_); }
  Outcome factorize(const NewtonWeights<std::complex<double>>& weights) override {
    return factorize(weights, &complex_);
  }
  void solve(double* y, double* mu) override { solve(&real_, y, mu); }
  void solve(std::complex<double>* y, std::complex<double>* mu) override { solve(&complex_, y, mu); }

 private:
  /// Made by the first factorization: a scheme need not want both.
  template <class T>
  struct Factor {
    std::unique_ptr<SparseLu<T>> lu;
    std::vector<T> unknowns;
  };
  template <class T>
  Outcome factorize(const NewtonWeights<T>& weights, Factor<T>* factor);
  template <class T>
  void solve(Factor<T>* factor, T* y, T* mu);
  NewtonPlan::Values values() const;
  /// Rows that join supports alone are no unknowns.
  std::size_t num_active_rows() const { return model_.numbering.first_idle_row(); }

  Model& model_;
  std::span<const double> multipliers_;
  std::size_t num_springs_;
  NewtonPlan plan_;
  std::vector<double> blocks_, blocks_at_newton_;  // K of the last `evaluate`, and of the last `linearise`
  std::vector<double> reactions_;                  // [3n] M^-1 K lambda
  std::vector<double> product_;                    // [3 moving points] scratch
  std::vector<Block3> point_positions_, point_velocities_, coupling_positions_, coupling_velocities_;
  double linearised_at_ = 0.0;  // s
  Factor<double> real_;
  Factor<std::complex<double>> complex_;
};

}  // namespace tanor
