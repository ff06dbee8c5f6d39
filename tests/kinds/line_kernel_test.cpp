/// The two distances of a point from a line are along a pair of unit vectors, whose choice and turning are tested.

#include <array>

#include <gtest/gtest.h>

#include "evaluate/constraint_scenes.hpp"

namespace tanor::constraint_scenes {
namespace {

TEST(LineConstraint, TwoRowsTogetherAreTheDistanceFromTheLine) {
  Scene scene = make_scene({"", [](Random& any) { return Lines{"", {0}, any.vector(), any.vector()}; }}, 3);
  const auto& line = std::get<Lines>(scene.system.constraints[0]);
  const auto o = line.origin(t), d = line.direction(t);
  const Eigen::Vector3d origin(o[0].value(), o[1].value(), o[2].value());
  const Eigen::Vector3d direction(d[0].value(), d[1].value(), d[2].value());
  const Eigen::Vector3d from_origin = reference::point(scene.r, 0) - origin;

  const Eigen::VectorXd xi = Evaluated(scene).xi();

  EXPECT_NEAR(xi.norm(), from_origin.cross(direction.normalized()).norm(), 1e-14);
}

/// Point 0 on a line whose direction turns, at one time after another.
class TurningLine {
 public:
  explicit TurningLine(const VectorFunction& direction, double start = 0.0) {
    system_.positions = {0.3, -0.4, 0.5};
    system_.masses = {1.0};
    system_.constraints = {Lines{"", {0}, Vector3{0.1, 0.2, -0.3}, direction}};
    constraints_.emplace(system_, number(system_), start);
  }

  /// Returns e1 and e2.
  std::array<Eigen::Vector3d, 2> pair_at(double time) {
    std::vector<double> blocks(6);
    constraints_->set_time(time);
    constraints_->choose_frames();
    constraints_->evaluate_gradients(Parallel(1), r_.data(), blocks.data());
    return {reference::point(blocks, 0), reference::point(blocks, 1)};
  }

  Eigen::Vector3d direction_at(double time) const {
    const auto d = std::get<Lines>(system_.constraints[0]).direction(time);
    return Eigen::Vector3d(d[0].value(), d[1].value(), d[2].value()).normalized();
  }

  /// Returns xi, d xi/dt and d2 xi/dt2 of the point at rest.
  std::array<Eigen::Vector2d, 3> jet_at(double time) {
    std::array<Eigen::Vector2d, 3> result;
    const std::vector<double> zero(3, 0.0);
    const Parallel serial(1);
    constraints_->set_time(time);
    (void)constraints_->evaluate_values(serial, r_.data(), result[0].data());
    (void)constraints_->evaluate_rates(serial, r_.data(), zero.data(), result[1].data());
    (void)constraints_->evaluate_right_side(serial, r_.data(), zero.data(), zero.data(), result[2].data(), nullptr);
    return result;
  }

 private:
  System system_;
  std::optional<Constraints> constraints_;
  std::vector<double> r_ = {0.7, 0.2, -0.6};
};

VectorFunction formulas(const char* x, const char* y, const char* z) {
  return {ScalarFunction::formula(x), ScalarFunction::formula(y), ScalarFunction::formula(z)};
}

/// The directions turn around an axis, past two axes, and through the axis that is farthest at the start, so that this
/// axis must be given up.
const std::array turns = {formulas("cos(t)", "sin(t)", "5"), formulas("cos(t)", "0.1", "sin(t)"),
                          formulas("cos(t)", "sin(t)", "0.01*t"), formulas("cos(t)", "0.02", "0.01 + sin(t)")};

/// Returns the axis of e1, which is the one farthest from d, and the first of several equal ones.
int axis_of(const Eigen::Vector3d& d) {
  int best = 0;
  for (const int k : {1, 2}) {
    if (std::abs(d[k]) < std::abs(d[best]) - 1e-6) best = k;
  }
  return best;
}

TEST(LineConstraint, PairDependsOnTheDirectionAloneWhateverTimesAreSeen) {
  Random any(6);
  for (const VectorFunction& direction : turns) {
    TurningLine line(direction), late(direction, 3.0);
    for (int look = 0; look < 500; ++look) {
      const double time = any.number(0.0, 7.0);

      const auto [e1, e2] = line.pair_at(time);

      EXPECT_EQ(line.pair_at(time), late.pair_at(time)) << time;
      const Eigen::Vector3d d = line.direction_at(time), h = Eigen::Vector3d::Unit(axis_of(d));
      EXPECT_LE((e1 - (h - h.dot(d) * d).normalized()).norm(), 1e-14) << time;
      EXPECT_LE((e2 - d.cross(e1)).norm(), 1e-14) << time;
    }
  }
}

TEST(LineConstraint, RatesOfATurningPairAreItsDerivatives) {
  // At all five instants the pair keeps the axis that was chosen at the middle instant.
  constexpr double h = 1e-3;
  for (const VectorFunction& direction : turns) {
    TurningLine line(direction);
    for (double time = 0.05; time < 7.0; time += 0.05) {
      (void)line.pair_at(time);
      const auto far_before = line.jet_at(time - 2 * h), before = line.jet_at(time - h), now = line.jet_at(time),
                 after = line.jet_at(time + h), far_after = line.jet_at(time + 2 * h);

      for (std::size_t order = 0; order < 2; ++order) {
        const Eigen::Vector2d slope =
            (8.0 * (after[order] - before[order]) - (far_after[order] - far_before[order])) / (12.0 * h);
        ASSERT_LE((now[order + 1] - slope).norm(), 1e-5 * std::max(1.0, slope.norm())) << time << ", order " << order;
      }
    }
  }
}

}  // namespace
}  // namespace tanor::constraint_scenes
