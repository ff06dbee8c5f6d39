#pragma once

#include <algorithm>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/roles.hpp"
#include "dynamics/workspace.hpp"

/// \file The common part of equations of motion whose variables are the positions of points themselves.
namespace tanor::detail {

class PointPassages final : public ForcePassages {
 public:
  explicit PointPassages(Workspace& work) : work_(work) {}
  std::size_t num_points() const override { return work_.model().num_points(); }
  Kinematics find_points(const Kinematics& at, double*, double*) override { return at; }
  bool act_briefly() const override { return work_.forces.act_briefly() || !work_.constraint_passages.empty(); }
  bool may_jump() const override { return work_.forces.may_jump(); }
  double find_passage(PointPath* path) override { return work_.find_passage(work_.constraint_passages, path); }
  std::string find_collision(const Kinematics& points, double within) override {
    return work_.find_collision(points, within);
  }

 private:
  Workspace& work_;
};

class PointDrives final : public DriveMonitor {
 public:
  explicit PointDrives(Workspace& work) : work_(work) {}
  DriveReport look_at_drives(const DrivenStep& step) override {
    return work_.drives.look(step, {step.x, step.v, work_.scales});
  }
  std::string name_drive(std::size_t drive) const override { return work_.drives.name(drive); }

 private:
  Workspace& work_;
};

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
class PointForm : public OwnEquations {
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
  void prescribe(double t, double* r, double* v) override { work_.prescribe(t, r, v); }
  std::size_t rank() const final { return work_.rank; }
  Energy energy(double t, const double* r, const double* v) override { return work_.energy(t, r, v); }
  double potential(double t, const double* r) override { return work_.potential(t, r); }

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
      : work_(work), model_(work.model()), passages_(work), drives_(work), rounding_(work) {}
  /// Returns the roles that every form of points has.
  Roles common_roles() {
    return {.force_passages = work_.may_be_passed(work_.constraint_passages) ? &passages_ : nullptr,
            .drives = !work_.drives.empty() ? &drives_ : nullptr};
  }
  RoundingGroups* rounding() { return &rounding_; }

  Workspace& work_;
  const Model& model_;

 private:
  PointPassages passages_;
  PointDrives drives_;
  PointRounding rounding_;
};

}  // namespace tanor::detail
