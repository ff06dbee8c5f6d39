#pragma once

#include <array>
#include <span>
#include <vector>

#include "motion/scheme.hpp"

namespace tanor::detail {

/// An explicit Runge-Kutta method with s stages: nodes c, strictly lower matrix A, weights b. The error weights are e =
/// b - b^, whose entry s + 1 belongs to a stage at the new point; e is empty if there is no estimate. e3 is the same
/// for a method of lower order, or empty.
struct Tableau {
  int order;
  std::vector<double> c;
  std::vector<std::vector<double>> a;
  std::vector<double> b, e, e3;
  /// Additional stages, after the one at the new point, and d, a row for each power that they add inside the step.
  struct Dense {
    std::vector<double> c;
    std::vector<std::vector<double>> a, d;
  } dense;
};

Tableau rk4_tableau();
Tableau dopri5_tableau();
Tableau dop853_tableau();

/// Integrates x'' = a(t, x, v) by an explicit Runge-Kutta method. The new point is projected onto the constraints, and
/// the acceleration there is the first stage of the next step (and the last one of the error estimate).
class RungeKutta final : public Scheme {
 public:
  RungeKutta(const Tableau& tableau, const IntegrationOptions& options, Mechanics& mechanics);

  int order() const override { return tableau_.order; }
  bool is_adaptive() const override { return !tableau_.e.empty(); }
  RoundingGain rounding_gain() const override { return {.factor = rounding_gain_}; }
  bool knows_acceleration() const override { return true; }
  bool sees_through(const State&) override { return false; }
  StepResult step(const State& from, double h, State* to) override;
  Outcome prepare_inside(const State& from, const State& to) override;
  void interpolate(const Parallel& parallel, const State& from, const State& to, double fraction, double* x,
                   double* v) const override;
  std::span<const double> looks() const override { return looks_; }
  bool interpolates_at_once() const override { return tableau_.dense.c.empty(); }
  void forget() override {}                  // each step evaluates all its stages
  void exchange_memory(Memory&) override {}  // likewise

 private:
  static constexpr std::size_t most_stages = 16;

  /// Weights of the accelerations in v, and in x. The latter are the former times A, since stages of x follow those of
  /// v.
  struct Weights {
    std::vector<double> v, x;
  };
  using Accelerations = std::array<const double*, most_stages>;

  void distribute_error();
  Weights weigh(const std::vector<double>& weights) const;
  Accelerations accelerations(const State& from, const State& to) const;
  Outcome evaluate_stages(const State& from, double h, const Accelerations& a, Power* work);
  Outcome evaluate_stage(const State& from, double h, double c, const Weights& row, const Accelerations& known,
                         double allowed_error, const AccelerationOutput& to);
  double estimate_error(const State& from, double h, const State& to);
  double measure(const State& from, double h, const State& to, const Weights& estimate);

  Tableau tableau_;
  double rounding_gain_ = 0.0;
  IntegrationOptions options_;
  Mechanics& mechanics_;
  std::vector<Weights> rows_;     // rows of A: the stages, the new point (b), the stages of the dense output
  Weights estimate_, estimate3_;  // e, e3
  std::vector<Weights> powers_;   // d
  std::vector<std::vector<double>> accelerations_;  // of all stages but the first, then of the dense output's
  std::vector<double> stage_x_, stage_v_;
  std::vector<double> zero_;
  std::vector<double> looks_;
  std::vector<double> shares_;  // part of a step's error that each stage may make
};

}  // namespace tanor::detail
