#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// The forces, and the `formulas`, that steps of equations of motion may pass unseen, and the functions of time. The
/// variables are positions of the points themselves unless `find_points` tells them.
class UnseenFeatures : public UnseenForces, public DriveMonitor {
 public:
  /// `find_points` needs room for so many numbers of positions and velocities.
  UnseenFeatures(Workspace& work, const Workspace::Formulas& formulas, std::size_t room = 0)
      : work_(work), formulas_(formulas), r_(room), v_(room) {}

  /// Returns the role of forces; null if none may be passed.
  UnseenForces* forces() { return work_.forces.may_be_passed() || !formulas_.empty() ? this : nullptr; }
  /// Returns the role of functions of time; null if there are none.
  DriveMonitor* drives() { return work_.drives.empty() ? nullptr : this; }

  std::size_t num_points() const override { return work_.model().num_points(); }
  bool act_briefly() const override { return work_.forces.act_briefly() || !formulas_.empty(); }
  bool may_jump() const override { return work_.forces.may_jump(); }
  double find_unseen(PointPath* path) override {
    const Parallel& parallel = work_.model().parallel;
    double part = work_.forces.find_unseen(parallel, path);
    for (const auto& formula : formulas_) part = std::min(part, formula->find(parallel, path));
    return part;
  }
  std::string find_collision(const Kinematics& points, double within) override {
    return work_.find_collision(points, within);
  }
  DriveReport look_at_drives(const DrivenStep& step) override {
    const Kinematics points = find_points({step.t, step.x, step.v}, r_.data(), v_.data());
    return work_.drives.look(step, {points.x, points.v, work_.scales});
  }
  std::string name_drive(std::size_t drive) const override { return work_.drives.name(drive); }

 protected:
  Workspace& work_;

 private:
  const Workspace::Formulas& formulas_;
  std::vector<double> r_, v_;  // scratch
};

}  // namespace tanor::detail
