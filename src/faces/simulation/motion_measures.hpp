#pragma once

#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/workspace.hpp"
#include "motion/integration.hpp"

namespace tanor::detail {

/// Positions, velocities and accelerations of all points, [3n] each, in the inner order.
struct PointState {
  std::vector<double> r, v, w;

  Kinematics at(double t) const { return {t, r.data(), v.data()}; }
};

/// Measures a motion for its report: violations, energy and its drift, friction. Warns if these show that the motion is
/// less exact than what was asked for.
class MotionMeasures {
 public:
  /// All arguments must outlive the object. `points` is overwritten with the present state wherever it is needed.
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

  /// Begins at the start, whose points are in `points`.
  void begin();
  /// Resumes a motion from its report.
  void resume();
  /// Measures after a step; `is_sound` is true if nothing failed so far.
  void take(const StepResult& step, bool is_sound);
  /// Refuses a motion of fixed steps whose energy comes from nowhere.
  Outcome check_growth() const;
  /// Takes over K'w + phi of the state's accelerations.
  void measure_acceleration();
  /// Measures friction at a step's end; iterations are counted wherever friction was found.
  void measure_friction(bool is_sound);

 private:
  void measure_violations(const StepResult& step);
  void note(const Energy& energy);
  double energy_of_a_fall() const;
  double energy_of_a_move();
  double change_of_potential();
  Vec3 direction_of(std::size_t i) const;
  void warn_of_tolerance();
  bool is_beyond_tolerances(double drift);
  void watch_accuracy();
  void watch_drift(double turn);
  bool is_drifting() const;
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
  double supply_ = 0.0;          ///< J, the most that was there, or came from anywhere
  int surges_ = 0;               ///< times that the kinetic energy was far above it
  bool has_pairs_ = false;       ///< true if some rank has pair forces
  bool warns_of_drift_ = false;  ///< true if the accuracy warning is about drift, which may become small again
};

}  // namespace tanor::detail
