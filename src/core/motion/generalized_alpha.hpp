#pragma once

#include <vector>

#include "motion/implicit_step.hpp"

namespace tanor::detail {

/// Generalized-alpha method of order 2 (Chung & Hulbert 1993; for constraints Arnold & Bruels 2007). A step takes one
/// Newton iteration with one real matrix and damps the fastest oscillations by the factor `spectral_radius`. The method
/// has an acceleration b of its own:
///
///   r_1 = r_0 + h v_0 + h^2 ((1/2 - beta) b_0 + beta b_1),   v_1 = v_0 + h ((1 - gamma) b_0 + gamma b_1)
///   (1 - alpha_m) b_1 + alpha_m b_0 = (1 - alpha_f) w_1 + alpha_f w_0,   M w_1 = f_1 + K_1 lambda,   xi(r_1, t_1) = 0
///
/// At the end v_1 is projected onto K'v + xi_t = 0.
class GeneralizedAlpha final : public Scheme {
 public:
  GeneralizedAlpha(const IntegrationOptions& options, Mechanics& mechanics);

  int order() const override { return 2; }
  bool is_adaptive() const override { return false; }
  bool ends_at_jumps() const override { return false; }
  bool knows_acceleration() const override { return true; }
  bool sees_through(const State&) override { return false; }
  StepResult step(const State& from, double h, State* to) override;
  void forget() override { knows_own_ = false; }
  void exchange_memory(Memory& memory) override {
    memory.exchange(knows_own_, own_time_, own_, lambda_);
    implicit_.exchange_memory(memory);
  }

 private:
  Outcome solve_step(const State& from, double h, State* to);
  Outcome iterate(const State& from, double h, State* to, bool* converged);
  double measure(const State& from, const State& to);
  double measure_rounding(const State& from, double h, const State& to);

  IntegrationOptions options_;
  ImplicitStep implicit_;
  Mechanics& mechanics_;
  ImplicitEquations& equations_;
  double alpha_m_, alpha_f_, beta_, gamma_;
  std::vector<double> own_, next_own_;  // b_0 and b_1
  double own_time_ = 0.0;
  bool knows_own_ = false;
  std::vector<double> lambda_, residual_, rows_, v_increment_;
};

}  // namespace tanor::detail
