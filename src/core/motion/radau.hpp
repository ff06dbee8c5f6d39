#pragma once

#include <array>
#include <complex>
#include <vector>

#include "motion/implicit_step.hpp"
#include "motion/radau_coefficients.hpp"

namespace tanor::detail {

/// Radau IIA of order 5 for stiff forces (Hairer & Wanner II, IV.8 and VII.4), with the stages
///
///   r_i = r_0 + h sum_j a_ij v_j,   M (v_i - v_0) = h sum_j a_ij (f_j + K_j lambda_j),   K_i'v_i + xi_t = 0
///
/// The form has index 2 and order 5 in r and v; the end of a step is projected onto xi = 0. Newton's iteration solves
/// one real and one complex system of the size of one evaluation. A factor is kept as long as the iteration converges
/// with it.
class Radau5 final : public Scheme {
 public:
  Radau5(const IntegrationOptions& options, Mechanics& mechanics);

  int order() const override { return 5; }
  int estimate_order() const override { return 4; }
  bool is_adaptive() const override { return true; }
  /// The estimate weighs the stages by up to 10 and its filter by 0.27, and the stages round independently.
  RoundingGain rounding_gain() const override { return {.factor = 4.0, .is_damped = true}; }
  double choose_step(double last, double wanted) const override;
  bool knows_acceleration() const override { return true; }
  bool sees_through(const State&) override { return false; }
  StepResult step(const State& from, double h, State* to) override;
  std::span<const double> looks() const override { return looks_; }
  void forget() override { knows_stages_ = false; }
  void exchange_memory(Memory& memory) override {
    memory.exchange(knows_stages_, begin_, end_, moved_, lambda_);
    implicit_.exchange_memory(memory);
  }

 private:
  template <class T>
  using Stages = std::array<std::vector<T>, 3>;

  void predict(const State& from, double h);
  void start_anew(const State& from);
  Outcome solve_stages(const State& from, double h, double t_end);
  Outcome iterate(const State& from, double h, double t_end, bool* converged);
  void place_stage(const State& from, double h, double t_end, std::size_t i);
  double stage_time(const State& from, double h, double t_end, std::size_t i) const;
  double take_increments(const State& from, double h);
  double estimate_error(const State& from, double h, const State& to);
  Outcome add_work(const State& from, double h, State* to);

  const RadauCoefficients radau_ = radau_coefficients();
  const std::array<double, 4> looks_{0.0, radau_.c[0], radau_.c[1], 1.0};
  IntegrationOptions options_;
  ImplicitStep implicit_;
  Mechanics& mechanics_;
  ImplicitEquations& equations_;
  // v_i - v_0 and lambda_i of the last step, from `begin_` to `end_`, from which the next ones are predicted.
  Stages<double> moved_, lambda_;
  double begin_ = 0.0, end_ = 0.0;
  bool knows_stages_ = false;
  // Workspaces of the stages, for residuals and then increments.
  Stages<double> x_, v_, a_, rows_;
  std::vector<std::complex<double>> pair_, pair_rows_;
};

}  // namespace tanor::detail
