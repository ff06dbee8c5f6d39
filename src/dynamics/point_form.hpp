#pragma once

#include <algorithm>

#include "dynamics/equations_of_motion.hpp"
#include "dynamics/model.hpp"
#include "dynamics/roles.hpp"

/// \file What equations of motion have in common whose variables are the positions of points themselves.
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

/// Equations of motion whose variables are the positions of points themselves.
class PointForm : public EquationsOfMotion {
 public:
  std::size_t size() const final { return 3 * model_.num_points(); }
  bool keeps_variables() const final { return true; }
  const Parallel& parallel() const final { return model_.parallel; }
  PointTolerances point_tolerances() const final {
    return {model_.scales.position_tolerances(), model_.scales.velocity_tolerances(), model_.scales.accelerations()};
  }
  void prescribe(double t, double* r, double* v) final { model_.prescribe(t, r, v); }
  std::size_t rank() const final { return model_.rank; }
  Energy energy(double, const double* r, const double* v) final { return model_.energy(r, v); }

  ForcePassages* force_passages() final {
    return model_.may_be_passed(model_.constraint_passages) ? &passages_ : nullptr;
  }
  DriveMonitor* drives() final { return !model_.drives.empty() ? &drives_ : nullptr; }

  Outcome set_state(double, const double* r, const double* v, double* x, double* x_dot) final {
    std::copy(r, r + size(), x);
    std::copy(v, v + size(), x_dot);
    return {};
  }
  void write_points(double, const double* x, const double* x_dot, const double* x_ddot, double* r, double* v,
                    double* w) final {
    std::copy(x, x + size(), r);
    std::copy(x_dot, x_dot + size(), v);
    std::copy(x_ddot, x_ddot + size(), w);
  }

 protected:
  explicit PointForm(Model& model) : model_(model), passages_(model), drives_(model), rounding_(model) {}
  RoundingGroups* rounding() { return &rounding_; }

  Model& model_;

 private:
  PointPassages passages_;
  PointDrives drives_;
  PointRounding rounding_;
};

}  // namespace tanor
