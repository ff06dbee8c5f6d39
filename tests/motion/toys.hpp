#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "motion/integration.hpp"

namespace tanor::toys {
using namespace detail;

/// A few numbers without constraints that obey x'' = a(t, x, v). It keeps the instants of its switches.
class Toy : public Mechanics, private StepProjector, private RankMonitor {
 public:
  explicit Toy(std::size_t size) : size_(size) {}

  std::vector<double> switch_times;

  std::size_t size() const override { return size_; }
  bool keeps_variables() const override { return true; }
  bool has_work() const override { return false; }
  void prescribe(double, double*, double*) override {}
  Outcome linearise(double t, const double*) override {
    linearised_at_ = t;
    return {};
  }
  /// Returns the power that belongs to the latest `push`.
  virtual Power power(const double* /*v*/) { return {}; }
  /// Evaluates x'' = a(t, x, v).
  virtual Outcome push(double t, const double* x, const double* v, double* a) = 0;
  Outcome accelerations(const Kinematics& at, const Request& request, const AccelerationOutput& to) override {
    if (request.gradients == Gradients::Evaluate) linearised_at_ = at.t;
    Outcome found = push(at.t, at.x, at.v, to.a);
    if (to.power != nullptr) *to.power = power(at.v);
    return found;
  }
  ProjectionReport project_positions(double, double*, Turn) override { return {}; }
  PointTolerances point_tolerances() const override { return {}; }
  std::size_t rank() const override { return 0; }

  bool depends_on_velocity() const override { return false; }
  bool is_constant() const override { return false; }
  const Vec3* uniform_acceleration() const override { return nullptr; }
  std::size_t num_moving() const override { return 0; }
  Outcome free_accelerations(const Kinematics& at, const Request&, double* a, double*) override {
    return push(at.t, at.x, at.v, a);
  }
  ProjectionReport project_step_velocities(double, double, const double*, double*) override { return {}; }
  double mass_ratio() const override { return 1.0; }
  void remember_gradients() override {}
  double compare_gradients() override { return 1.0; }

  Roles roles() override { return {.step_projector = this, .rank_monitor = this}; }
  SeriesExpansion* series(std::string*) override { return nullptr; }
  /// Moves nothing, but fails if the last linearisation is not at the step's beginning, as every mechanics requires.
  ProjectionReport project_step(double t, double h, const PointSource&, double*, double*) override {
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
  Reactions no_reactions() const override { return {}; }
  void exchange_memory(Memory&) override {}
  double reciprocal_condition() const override { return 1.0; }
  const Parallel& parallel() const override { return parallel_; }

 private:
  std::size_t size_;
  double linearised_at_ = -1.0;
  Parallel parallel_{1};
};

/// A toy whose equations switch. Its functions have no kinks, and it has no discrete state.
class SwitchingToy : public Toy, private EventFunctions {
 public:
  using Toy::Toy;

  Roles roles() override {
    Roles roles = Toy::roles();
    roles.events = this;
    return roles;
  }
  void shape_events(const Reactions&, const double* values, double* shapes) const override {
    std::copy_n(values, num_events(), shapes);
  }
  Power work_of_switch() const override { return {}; }
  std::vector<int> discrete_state() const override { return {}; }
  void restore_discrete_state(std::span<const int>) override {}
};

/// A block on a spring whose far end is drawn with u, x'' = k (u t - x) - F. Coulomb friction holds the block up to the
/// friction of rest, and slows it by that of sliding.
class Block final : public SwitchingToy {
 public:
  Block(double stiffness, double drive, double rest, double sliding)
      : SwitchingToy(1), stiffness_(stiffness), drive_(drive), rest_(rest), sliding_(sliding) {}

  int direction = 0;  ///< of sliding; 0 if it sticks

  Outcome push(double t, const double* x, const double*, double* a) override {
    pull_ = stiffness_ * (drive_ * t - x[0]);
    a[0] = direction == 0 ? 0.0 : pull_ - direction * sliding_;
    return {};
  }
  std::size_t num_events() const override { return 1; }
  void evaluate_events(const Kinematics& at, const Reactions&, double* values) override {
    values[0] = direction == 0 ? rest_ - std::abs(pull_) : direction * at.v[0];
  }
  Outcome switch_equations(double t, const double* x, double* v, std::span<const std::size_t>, const Request&,
                           const AccelerationOutput& to) override {
    switch_times.push_back(t);
    const bool stuck = direction == 0;
    v[0] = 0.0;
    direction = stuck || std::abs(pull_) > rest_ ? (pull_ > 0.0 ? 1 : -1) : 0;
    return push(t, x, v, to.a);
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
    const Outcome found = toy.accelerations(integration.state.at(), {}, integration.state.a.data());
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
