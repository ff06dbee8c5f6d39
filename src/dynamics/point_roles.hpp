#pragma once

#include "dynamics/model.hpp"
#include "dynamics/roles.hpp"

/// \file Roles of equations of motion whose variables are the positions of points themselves.
namespace tanor {

class PointPassages final : public ForcePassages {
 public:
  explicit PointPassages(Model& model) : model_(model) {}
  std::size_t num_points() const override { return model_.num_points(); }
  Kinematics find_points(const Kinematics& at, double*, double*) override { return at; }
  double find_passage(PointPath* path) override { return model_.find_passage(model_.constraint_passages, path); }

 private:
  Model& model_;
};

class PointDrives final : public DriveMonitor {
 public:
  explicit PointDrives(Model& model) : model_(model) {}
  DriveReport look_at_drives(const DrivenStep& step) override {
    return model_.drives.look(step, {step.x, step.v, nullptr, model_.scales});
  }
  std::string name_drive(std::size_t drive) const override { return model_.drives.name(drive); }

 private:
  Model& model_;
};

class PointRounding final : public RoundingGroups {
 public:
  explicit PointRounding(Model& model) : model_(model) {}
  std::size_t num_groups() const override { return model_.joints.num_groups(); }
  void largest_differences(const double* a, const double* b, std::span<double> largest) const override {
    model_.joints.largest_differences(a, b, largest);
  }
  double allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target) override {
    return model_.joints.allow_rounding(levels, gain, target, model_.scales);
  }

 private:
  Model& model_;
};

}  // namespace tanor
