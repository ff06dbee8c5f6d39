#pragma once

#include "dynamics/constrained_system.hpp"
#include "dynamics/forward_dynamics.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/residuals.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The response of multipliers at the linearized configuration.
class LinearizedResponse final : public ContactResponse {
 public:
  LinearizedResponse(Workspace& work, Linearization& linearization) : work_(work), linearization_(linearization) {}

  void solve_once(const double* b, double* x) override {
    ++work_.counters.solves;
    linearization_.solve_negative(b, x);
  }
  void solve_refined(const double* b, double* x, double* dw) override {
    points_.resize(3 * work_.model().num_points());
    linearization_.solve_refined(b, x, dw != nullptr ? dw : points_.data());
  }
  void minimize_multiplier_norm(double* x) override { linearization_.dependences().minimize_norm(x); }

 private:
  Workspace& work_;
  Linearization& linearization_;
  std::vector<double> points_;  // [3n] scratch
};

/// The constrained system as contacts see it, in equations with multipliers.
class MultiplierSystem final : public ConstrainedSystem {
 public:
  MultiplierSystem(Linearization& linearization, Residuals& residuals, Projector& projector, ForwardDynamics& dynamics,
                   ContactResponse& response)
      : linearization_(linearization),
        residuals_(residuals),
        projector_(projector),
        dynamics_(dynamics),
        response_(response) {}

  ContactResponse& response() override { return response_; }
  GramSolver& gram() override { return linearization_.gram(); }
  Outcome linearise(double t, const double* r) override { return linearization_.update(t, r); }
  ProjectionReport project_velocities(double t, const double* r, double* v, double* impulses) override {
    return projector_.project_velocities(t, r, v, impulses);
  }
  Outcome accelerations(const Kinematics& at, const Request& request, std::span<const char> are_counted,
                        const AccelerationOutput& to) override {
    return dynamics_.solve(at, request, are_counted, to);
  }

  std::vector<double>& lambda() override { return dynamics_.multipliers(); }
  const std::vector<double>& acceleration_scales() const override { return residuals_.accelerations(); }
  const std::vector<double>& measure_accelerations(const double* w0, const double* b, double scale) override {
    residuals_.begin_instant();
    return residuals_.measure_accelerations({w0, b, scale});
  }

  const std::vector<double>& blocks() const override { return linearization_.blocks(); }
  const Dependences& redundancy() const override { return linearization_.dependences(); }
  void minimize_multiplier_norm(const double* r, double* lambda) override {
    linearization_.minimize_multiplier_norm(r, lambda);
  }

 private:
  Linearization& linearization_;
  Residuals& residuals_;
  Projector& projector_;
  ForwardDynamics& dynamics_;
  ContactResponse& response_;
};

}  // namespace tanor::detail
