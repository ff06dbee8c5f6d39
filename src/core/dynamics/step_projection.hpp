#pragma once

#include <limits>
#include <vector>

#include "dynamics/contacts.hpp"
#include "dynamics/forward_dynamics.hpp"
#include "dynamics/linearization.hpp"
#include "dynamics/projector.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// Both halves of a step of RATTLE in positions and velocities of points. The first guess comes from the multipliers of
/// the last steps, and friction is that of the step's own multipliers.
class StepProjection final : public StepProjector {
 public:
  /// `friction` is null if constraints are ideal.
  StepProjection(Workspace& work, Linearization& linearization, Projector& projector, ForwardDynamics& dynamics,
                 Contacts* contacts);

  bool depends_on_velocity() const override { return work_.forces.depends_on_velocity() || contacts_ != nullptr; }
  bool is_constant() const override {
    return contacts_ == nullptr && model_.uniform_free() != nullptr && !model_.has_moving_supports();
  }
  const Vec3* uniform_acceleration() const override {
    return contacts_ == nullptr && work_.team().is_alone() ? model_.uniform_free() : nullptr;
  }
  std::size_t num_moving() const override { return model_.num_moving(); }
  Outcome free_accelerations(const Kinematics& at, const Request& request, double* w, double* largest) override;
  ProjectionReport project_step(double t, double h, const PointSource& source, double* r,
                                double* step_velocity) override {
    return project_step(t, h, r, &source, step_velocity, 0.0);
  }
  /// `source` brings r, or is null if r is there already; `step_velocity` may be null. Stops where |xi|/length is at
  /// most `tolerance`; 0 asks for rounding.
  ProjectionReport project_step(double t, double h, double* r, const PointSource* source, double* step_velocity,
                                double tolerance);
  ProjectionReport project_step_velocities(double t, double h, const double* r, double* v) override;

  /// The sum of the last `project_step`, [d]: 2/h times it is the step's multipliers. NaN if K lost rank there.
  const std::vector<double>& sum() const { return step_.sum; }

  /// Forgets the multipliers of earlier steps.
  void forget_steps();
  void exchange_memory(Memory& memory);

 private:
  struct StepMultipliers {
    std::vector<double> sum;           // in this step's iterations
    std::vector<double> last, before;  // of the last two steps, over h^2; 0 if the frames of lines have jumped
    std::size_t frames = 0;            // number of the frames of lines (their unit vectors)
    double last_h = std::numeric_limits<double>::max(), before_h = last_h;  // s, lengths of those steps
  };

  void guess_step(double h);
  void keep_step(double h);
  ProjectionReport project_singular_step(double t, double h, double* r, double* step_velocity);
  ProjectionReport iterate_step_friction(double t, double h, double* r, double* step_velocity, ProjectionReport report);
  bool steps_with_friction() const;

  Workspace& work_;
  const Model& model_;
  Linearization& linearization_;
  Projector& projector_;
  ForwardDynamics& dynamics_;
  Contacts* contacts_;  // null if constraints are ideal
  StepMultipliers step_;
  std::vector<double> lambda_;      // [d] of the step, scratch
  std::vector<double> step_start_;  // [3n] used if rows depend
  Reactions found_;                 // with friction, scratch
  std::vector<double> eta_;         // [3n] scratch
};

}  // namespace tanor::detail
