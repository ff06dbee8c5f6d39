#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "motion/integration.hpp"

namespace tanor::toys {

/// x'' = a(t, x, v) of a few numbers without constraints; keeps the instants of its switches.
class Toy : public Mechanics {
 public:
  explicit Toy(std::size_t size) : size_(size) {}

  std::vector<double> switch_times;

  std::size_t size() const override { return size_; }
  bool depends_on_velocity() const override { return false; }
  bool has_work() const override { return false; }
  void prescribe(double, double*, double*) override {}
  Outcome linearise(double t, const double*) override {
    linearised_at_ = t;
    return {};
  }
  Outcome accelerations(double t, const double* x, const double* v, Gradients gradients, double* a) override {
    if (gradients == Gradients::Evaluate) linearised_at_ = t;
    return free_accelerations(t, x, v, a);
  }
  ProjectionReport project_positions(double, double*) override { return {}; }
  /// Moves nothing, but is held to the K of the step's beginning as every mechanics is.
  ProjectionReport project_step(double t, double h, double*, double*) override {
    ProjectionReport report;
    if (std::abs(linearised_at_ - (t - h)) > 1e-14) {
      report.outcome = {Status::NotConverged, "K is not that of the step's beginning"};
    }
    return report;
  }
  ProjectionReport project_velocities(double, const double*, double*) override { return {}; }
  ErrorRatios error_ratios(double, const StepErrors& errors, double atol, double rtol) override {
    ErrorRatios result{};
    for (std::size_t i = 0; i < size_; ++i) {
      result.x = std::max(result.x, std::abs(errors.x[i]) / (atol + rtol * std::abs(errors.x_to[i])));
      result.v = std::max(result.v, std::abs(errors.v[i]) / (atol + rtol * std::abs(errors.v_to[i])));
    }
    return result;
  }
  bool has_drives() const override { return false; }
  DriveReport look_at_drives(const DrivenStep&) override { return {}; }
  std::string name_drive(std::size_t) const override { return {}; }
  Power power(const double*, const double*) const override { return {}; }
  void exchange_memory(Memory&) override {}
  Energy energy(double, const double*, const double*) override { return {}; }
  const SolveReport& last_solve() const override { return solve_; }
  const Parallel& parallel() const override { return parallel_; }

 private:
  std::size_t size_;
  double linearised_at_ = -1.0;
  SolveReport solve_;
  Parallel parallel_{1};
};

/// A block on a spring, x'' = k (u t - x) - F, whose far end is drawn with u. Coulomb friction holds it up to the
/// friction of rest, and slows it by that of sliding.
class Block final : public Toy {
 public:
  Block(double stiffness, double drive, double rest, double sliding)
      : Toy(1), stiffness_(stiffness), drive_(drive), rest_(rest), sliding_(sliding) {}

  int direction = 0;  ///< of sliding; 0: it sticks

  Outcome free_accelerations(double t, const double* x, const double*, double* a) override {
    pull_ = stiffness_ * (drive_ * t - x[0]);
    a[0] = direction == 0 ? 0.0 : pull_ - direction * sliding_;
    return {};
  }
  std::size_t num_events() const override { return 1; }
  void evaluate_events(double, const double*, const double* v, double* values) override {
    values[0] = direction == 0 ? rest_ - std::abs(pull_) : direction * v[0];
  }
  Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t>, double* a) override {
    switch_times.push_back(t);
    const bool stuck = direction == 0;
    v[0] = 0.0;
    direction = stuck || std::abs(pull_) > rest_ ? (pull_ > 0.0 ? 1 : -1) : 0;
    return free_accelerations(t, x, v, a);
  }
  std::vector<int> discrete_state() const override { return {direction}; }
  void restore_discrete_state(std::span<const int> state) override { direction = state[0]; }

 private:
  double stiffness_, drive_, rest_, sliding_;
  double pull_ = 0.0;  // of the last accelerations
};

/// An integration of a toy from (x, v) at t = 0.
struct Travel {
  Travel(Toy& toy, Method method, const MotionOptions& options, const std::vector<double>& x,
         const std::vector<double>& v)
      : integration(method, options, toy, &report) {
    place(toy, 0.0, x, v);
    integration.next_step = options.step;
  }

  void place(Toy& toy, double t, const std::vector<double>& x, const std::vector<double>& v) {
    integration.state.t = t;
    integration.state.x = x;
    integration.state.v = v;
    const Outcome found = toy.accelerations(t, x.data(), v.data(), Gradients::Evaluate, integration.state.a.data());
    if (!found.ok()) throw std::runtime_error(found.what);
    integration.begin();
  }

  Outcome advance(double t_end, const Integration::Observer& observer = {}) {
    return integration.advance(
        t_end, [this](const StepResult&) { ++report.steps; }, observer);
  }

  MotionReport report;
  Integration integration;
};

}  // namespace tanor::toys
