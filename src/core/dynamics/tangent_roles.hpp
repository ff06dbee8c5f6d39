#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/roles.hpp"
#include "dynamics/tangent_dynamics.hpp"
#include "dynamics/unseen_features.hpp"

/// \file The roles of equations of motion in coordinates.
namespace tanor::detail {

class TangentFeatures final : public UnseenFeatures {
 public:
  explicit TangentFeatures(Workspace& work)
      : UnseenFeatures(work, work.coordinate_features, 3 * work.model().num_points()) {}
  Kinematics find_points(const Kinematics& at, double* r, double* v) override;
};

/// The events of the equations with multipliers that friction is taken from.
class TangentEvents final : public EventFunctions {
 public:
  TangentEvents(TangentLinearization& linearization, TangentDynamics& dynamics)
      : linearization_(linearization), dynamics_(dynamics) {}
  bool has_some() const { return dynamics_.friction() != nullptr && dynamics_.friction()->events() != nullptr; }

  std::size_t num_events() const override { return others().num_events(); }
  void evaluate_events(const Kinematics& at, const Reactions& found, double* values) override;
  void shape_events(const Reactions&, const double* values, double* shapes) const override {
    std::copy_n(values, num_events(), shapes);
  }
  Outcome switch_equations(double t, const double* q, double* q_dot, std::span<const std::size_t> which,
                           const Request& request, const AccelerationOutput& to) override;
  Power work_of_switch() const override { return others().work_of_switch(); }
  std::vector<int> discrete_state() const override { return others().discrete_state(); }
  std::string describe_change(std::span<const int> before) const override { return others().describe_change(before); }
  void restore_discrete_state(std::span<const int> state) override { others().restore_discrete_state(state); }

 private:
  EventFunctions& others() const { return *dynamics_.friction()->events(); }

  TangentLinearization& linearization_;
  TangentDynamics& dynamics_;
};

}  // namespace tanor::detail
