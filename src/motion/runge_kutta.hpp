#pragma once

#include <array>
#include <span>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor {

/// An explicit Runge-Kutta method: stages c, A (strictly lower), weights b; e = b - b^ (empty: no error estimate),
/// whose last entry belongs to a stage at the new point.
struct Tableau {
  int order;
  std::vector<double> c;
  std::vector<std::vector<double>> a;
  std::vector<double> b, e;
};

Tableau rk4_tableau();
Tableau dopri5_tableau();

/// x'' = a(t, x, v) by an explicit Runge-Kutta method; the new point is put onto the constraints, and the acceleration
/// there is the first stage of the next step (and the last one of the error estimate).
class RungeKutta final : public Scheme {
 public:
  RungeKutta(const Tableau& tableau, const MotionOptions& options, Mechanics& mechanics);

  int order() const override { return tableau_.order; }
  bool is_adaptive() const override { return !tableau_.e.empty(); }
  StepResult step(const State& from, double h, State* to) override;

 private:
  static constexpr std::size_t most_stages = 16;

  double estimate_error(const State& from, double h, const State& to, std::span<const double* const> a);

  Tableau tableau_;
  MotionOptions options_;
  Mechanics& mechanics_;
  std::vector<std::vector<double>> a_squared_;  // A^2
  std::vector<double> b_a_, e_a_;               // b'A, and the same of the estimate
  std::vector<std::vector<double>> accelerations_;
  std::vector<double> stage_x_, stage_v_;
  std::vector<double> zero_;
};

}  // namespace tanor
