#include <tanor/velocity_verlet.hpp>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "host/host_input.hpp"
#include "host/point_address.hpp"

namespace tanor {
using namespace detail;

namespace {

/// A step on a host's arrays, which keeps the state in which it begins.
class Step {
 public:
  Step(Constrainer* constrainer, const VelocityVerlet& run)
      : constrainer_(constrainer),
        run_(run),
        num_points_(constrainer->num_points()),
        arrays_{run.positions, run.velocities, run.forces} {
    for (auto& kept : kept_) kept.resize(num_points_);
  }

  /// Takes a step. Returns the reports of constrain_positions and constrain_velocities. If one of them fails, the
  /// arrays are as they were before.
  std::array<ConstraintReport, 2> take(double time) {
    for (std::size_t k = 0; k < arrays_.size(); ++k)
      for (std::size_t i = 0; i < num_points_; ++i) kept_[k][i] = read_point(arrays_[k], i);
    try {
      std::array<ConstraintReport, 2> reports = try_to_take(time);
      if (!reports[0].outcome.ok() || !reports[1].outcome.ok()) go_back();
      return reports;
    } catch (...) {
      go_back();
      throw;
    }
  }

 private:
  std::array<ConstraintReport, 2> try_to_take(double time) {
    kick();
    for (std::size_t i = 0; i < num_points_; ++i) add(run_.step, run_.velocities, i, run_.positions);
    std::array<ConstraintReport, 2> reports;
    reports[0] =
        constrainer_->constrain_positions({.step = run_.step,
                                           .old_positions = {kept_[0].empty() ? nullptr : kept_[0].front().data()},
                                           .positions = run_.positions,
                                           .velocities = run_.velocities,
                                           .time = time,
                                           .measures = run_.measures,
                                           .tolerance = run_.tolerance});
    if (!reports[0].outcome.ok()) return reports;
    if (run_.set_forces) run_.set_forces(time);
    kick();
    reports[1] = constrainer_->constrain_velocities({.step = run_.step,
                                                     .positions = run_.positions,
                                                     .velocities = run_.velocities,
                                                     .time = time,
                                                     .measures = run_.measures});
    return reports;
  }

  /// Computes v += h/2 M^-1 f with the present masses, which an observer may have changed. A support's mass is
  /// infinite.
  void kick() {
    for (std::size_t i = 0; i < num_points_; ++i)
      add(0.5 * run_.step / constrainer_->mass(static_cast<Index>(i)), run_.forces, i, run_.velocities);
  }
  static void add(double factor, const ConstPointArray& what, std::size_t i, const PointArray& to) {
    std::array<double, 3> sum = read_point(to, i);
    const std::array<double, 3> term = read_point(what, i);
    for (std::size_t d = 0; d < 3; ++d) sum[d] += factor * term[d];
    write_point(sum, to, i);
  }
  void go_back() {
    for (std::size_t k = 0; k < arrays_.size(); ++k)
      for (std::size_t i = 0; i < num_points_; ++i) write_point(kept_[k][i], arrays_[k], i);
  }

  Constrainer* const constrainer_;
  const VelocityVerlet& run_;
  const std::size_t num_points_;
  const std::array<PointArray, 3> arrays_;
  std::array<std::vector<std::array<double, 3>>, 3> kept_;  // [array][point] at the beginning of the step
};

}  // namespace

VelocityVerletReport run(Constrainer* constrainer, const VelocityVerlet& run) {
  require_array(run.positions, constrainer->num_points(), "positions");
  require_array(run.velocities, constrainer->num_points(), "velocities");
  require_array(run.forces, constrainer->num_points(), "forces");
  Step step(constrainer, run);
  VelocityVerletReport report{.outcome = {}, .steps = 0, .time = run.time};
  while (report.steps < run.steps) {
    const double time = run.time + run.step * static_cast<double>(report.steps + 1);
    auto [positions, velocities] = step.take(time);
    for (ConstraintReport* const each : {&positions, &velocities}) {
      if (each->outcome.ok()) continue;
      report.outcome = std::move(each->outcome);
      return report;
    }
    ++report.steps;
    report.time = time;
    if (run.observe && !run.observe({report.steps, time, positions, velocities})) break;
  }
  return report;
}

}  // namespace tanor
