#pragma once

#include <algorithm>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/unseen_features.hpp"
#include "dynamics/workspace.hpp"

/// \file The common part of equations of motion whose variables are the positions of points themselves.
namespace tanor::detail {

class PointRounding final : public RoundingGroups {
 public:
  explicit PointRounding(Workspace& work) : work_(work) {}
  std::size_t num_groups() const override { return work_.joints.num_groups(); }
  void largest_differences(const double* a, const double* b, std::span<double> largest) const override {
    work_.joints.largest_differences(a, b, largest);
  }
  double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target) override {
    return work_.joints.allow_rounding(levels, gain, target, work_.scales);
  }
  void exchange_allowance(Memory& memory) override { work_.joints.exchange_allowance(memory); }

 private:
  Workspace& work_;
};

/// Equations of motion whose variables are the positions of points themselves.
class PointForm : public EquationsOfMotion {
 public:
  std::size_t size() const final { return 3 * model_.num_points(); }
  bool keeps_variables() const final { return true; }
  const Parallel& parallel() const final { return model_.parallel; }
  PointTolerances point_tolerances() const final {
    return {work_.scales.position_tolerances(), work_.scales.velocity_tolerances(), work_.scales.accelerations()};
  }
  void fetch_guests(double* r, double* v) override {
    work_.team().fetch_guests(r);
    if (v != nullptr) work_.team().fetch_guests(v);
  }
  std::size_t rank_here() const final { return work_.rank; }
  Energy energy(double t, const double* r, const double* v) override { return sum_of_all(work_.energy(t, r, v)); }
  double potential(double t, const double* r) override { return sum(work_.potential(t, r)); }

  Outcome set_state(double, const double* r, const double* v, double* x, double* x_dot) final {
    std::copy(r, r + size(), x);
    std::copy(v, v + size(), x_dot);
    return {};
  }
  void write_points(const Kinematics& at, const double* x_ddot, const Reactions&, double* r, double* v,
                    double* w) final {
    std::copy(at.x, at.x + size(), r);
    std::copy(at.v, at.v + size(), v);
    std::copy(x_ddot, x_ddot + size(), w);
  }

 protected:
  explicit PointForm(Workspace& work)
      : work_(work), model_(work.model()), unseen_(work, work.constraint_features), rounding_(work) {}
  /// Returns the roles that every form of points has.
  Roles common_roles() { return {.unseen_forces = unseen_.forces(), .drives = unseen_.drives()}; }
  RoundingGroups* rounding() { return &rounding_; }

  Workspace& work_;
  const Model& model_;

 private:
  UnseenFeatures unseen_;
  PointRounding rounding_;
};

}  // namespace tanor::detail
