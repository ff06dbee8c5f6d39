#pragma once

#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/workspace.hpp"
#include "motion/integration.hpp"

namespace tanor {

/// Positions, velocities and accelerations of all points, [3n] each, in the inner order.
struct PointState {
  std::vector<double> r, v, w;

  Kinematics at(double t) const { return {t, r.data(), v.data()}; }
};

/// Measures a motion for its report: violations, energy and its drift, friction. Warns where these say that the motion
/// is less exact than what was asked for.
class MotionMeasures {
 public:
  /// All arguments outlive it. `points` is overwritten with the present state wherever it is needed.
  MotionMeasures(const MotionOptions& options, Workspace& work, EquationsOfMotion& form, Integration& integration,
                 PointState* points, MotionReport* report)
      : options_(options),
        work_(work),
        model_(work.model()),
        form_(form),
        integration_(integration),
        state_(integration.state),
        points_(*points),
        report_(*report) {}

  /// At the start, whose points are there.
  void begin();
  /// The report is that of a motion which goes on.
  void resume();
  /// After a step; `is_sound`: nothing failed so far.
  void take(const StepResult& step, bool is_sound);
  /// K'w + phi of the state's accelerations.
  void measure_acceleration();
  /// At a step's end; iterations are counted wherever friction was found.
  void measure_friction(bool is_sound);

 private:
  void measure_violations(const StepResult& step);
  void note(const Energy& energy);
  double energy_of_a_fall() const;
  double energy_of_a_move();
  double change_of_potential();
  double direction_of(std::size_t point, std::size_t component) const;
  void warn_of_tolerance();
  double tolerated_energy();
  void watch_accuracy();
  void watch_drift(double turn);
  std::string explain_drift() const;
  void write_points();

  const MotionOptions& options_;
  Workspace& work_;
  const Model& model_;
  EquationsOfMotion& form_;
  Integration& integration_;
  State& state_;
  PointState& points_;
  MotionReport& report_;
  std::vector<double> moved_;    // [3n] places near the points
  bool has_pairs_ = false;       ///< some rank has pair forces
  bool warns_of_drift_ = false;  ///< the accuracy warning is of the drift, which may become small again
};

}  // namespace tanor
