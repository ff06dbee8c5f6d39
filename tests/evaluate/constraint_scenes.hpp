#pragma once

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <tanor/user_kernel.hpp>

#include "base/parallel.hpp"
#include "evaluate/constraints.hpp"
#include "reference.hpp"

/// \file Each kind of constraint with each way to give its parameters, and the library's results for it.
namespace tanor::constraint_scenes {
using namespace detail;

inline constexpr double t = 0.7;

/// The random numbers of one test.
class Random {
 public:
  explicit Random(unsigned seed) : generator_(seed) {}
  double number(double low = -2.0, double high = 2.0) { return std::uniform_real_distribution(low, high)(generator_); }
  Vector3 vector() { return {number(), number(), number()}; }
  std::vector<double> numbers(std::size_t count) {
    std::vector<double> result(count);
    for (double& x : result) x = number();
    return result;
  }
  /// Returns a positive, smooth function of time.
  ScalarFunction length() {
    const double mean = number(1.0, 2.0), rate = number(0.5, 3.0);
    return ScalarFunction::custom([=](const Jet<2>& s) { return mean + 0.5 * sin(rate * s); });
  }
  VectorFunction moving_vector() { return {length(), length(), length()}; }

 private:
  std::mt19937 generator_;
};

/// A kind with one way to give its parameters. It has six points, of which the last one is a support.
struct Kind {
  const char* name;
  std::function<Constraint(Random&)> make;

  friend std::ostream& operator<<(std::ostream& out, const Kind& kind) { return out << kind.name; }
};

// clang-format off
inline const Kind kinds[] = {
    {"RodInitial", [](Random&) { return Rods{"", {{0, 1}, {5, 2}, {3, 1}}, {}, {}}; }},
    {"RodOneLength", [](Random&) { return Rods{"", {{0, 1}, {2, 5}}, 1.2, {}}; }},
    {"RodLengthEach", [](Random&) { return Rods{"", {{0, 1}, {2, 5}}, std::vector{1.2, 0.7}, {}}; }},
    {"RodMovingLength", [](Random& any) { return Rods{"", {{0, 1}, {2, 5}}, any.length(), {}}; }},
    {"RodMovingLengthEach", [](Random& any) {
       return Rods{"", {{0, 1}, {2, 5}}, std::vector{any.length(), any.length()}, {}}; }},
    {"RodWithOffset", [](Random& any) { return Rods{"", {{0, 1}, {2, 5}}, {}, {any.vector(), any.vector()}}; }},
    {"RodWithOffsetAndMovingLength", [](Random& any) {
       return Rods{"", {{0, 1}, {2, 5}}, any.length(), {any.vector(), any.vector()}}; }},
    {"Plane", [](Random& any) { return Planes{"", {0, 3}, any.vector(), 0.4}; }},
    {"PlaneInitial", [](Random& any) { return Planes{"", {0, 3}, any.vector(), {}}; }},
    {"PlaneMovingOffset", [](Random& any) { return Planes{"", {0, 3}, any.vector(), any.length()}; }},
    {"PlaneMovingNormal", [](Random& any) { return Planes{"", {0, 3}, any.moving_vector(), 0.4}; }},
    {"PlaneMovingNormalAndOffsets", [](Random& any) {
       return Planes{"", {0, 3}, any.moving_vector(), std::vector{any.length(), any.length()}}; }},
    {"Sphere", [](Random& any) { return Spheres{"", {1, 4}, any.vector(), 1.5}; }},
    {"SphereInitial", [](Random& any) { return Spheres{"", {1, 4}, any.moving_vector(), {}}; }},
    {"SphereMovingCenterAndRadius", [](Random& any) { return Spheres{"", {1, 4}, any.moving_vector(), any.length()}; }},
    {"Line", [](Random& any) { return Lines{"", {0, 4}, any.vector(), any.vector()}; }},
    {"LineMovingOrigin", [](Random& any) { return Lines{"", {0, 4}, any.moving_vector(), any.vector()}; }},
    {"LineMovingDirection", [](Random& any) { return Lines{"", {0, 4}, any.vector(), any.moving_vector()}; }},
    {"Circle", [](Random& any) { return Circles{"", {2, 3}, any.vector(), any.vector(), 1.1}; }},
    {"CircleInitial", [](Random& any) { return Circles{"", {2, 3}, any.vector(), any.moving_vector(), {}}; }},
    {"CircleMovingCenter", [](Random& any) { return Circles{"", {2, 3}, any.moving_vector(), any.vector(), 1.1}; }},
    {"CircleMovingNormal", [](Random& any) { return Circles{"", {2, 3}, any.vector(), any.moving_vector(), 1.1}; }},
    {"CircleAllMoves", [](Random& any) {
       return Circles{"", {2, 3}, any.moving_vector(), any.moving_vector(),
                      std::vector{any.length(), any.length()}}; }},
    {"Angle", [](Random&) { return Angles{"", {{0, 1, 2}, {3, 5, 4}}, 0.3}; }},
    {"AngleInitial", [](Random&) { return Angles{"", {{0, 1, 2}, {3, 5, 4}}, {}}; }},
    {"AngleMovingCosine", [](Random&) {
       return Angles{"", {{0, 1, 2}}, ScalarFunction::custom([](const Jet<2>& s) { return 0.5 * sin(2.0 * s); })}; }},
    {"Pulley", [](Random& any) { return Pulleys{"", {{0, 1}, {2, 5}}, any.vector(), any.vector(), 3.0, 1.0}; }},
    {"PulleyInitialWithRatio", [](Random& any) {
       return Pulleys{"", {{0, 1}, {2, 5}}, any.vector(), any.vector(), {}, -2.5}; }},
    {"PulleyMovingLength", [](Random& any) {
       return Pulleys{"", {{0, 1}, {2, 5}}, any.vector(), any.vector(), any.length(), 0.5}; }},
    {"LinearOnePoint", [](Random& any) { return Linears{"", {{0}, {4}}, {any.vector()}, 0.2}; }},
    {"LinearInitial", [](Random& any) {
       return Linears{"", {{0, 3}, {2, 5}}, {any.vector(), any.vector()}, {}}; }},
    {"LinearMovingValue", [](Random& any) {
       return Linears{"", {{0, 1, 2, 5}, {3, 4, 0, 1}},
                      {any.vector(), any.vector(), any.vector(), any.vector()}, any.length()}; }},
    {"Ellipsoid", [](Random& any) {
       return Ellipsoids{"", {1, 4}, any.vector(), {1.5, 0.8, 1.1}, {any.vector(), any.vector()}}; }},
    {"EllipsoidMovingCenter", [](Random& any) { return Ellipsoids{"", {1, 4}, any.moving_vector(), {1.5, 0.8, 1.1}}; }},
    {"HelixInitial", [](Random& any) { return Helices{"", {0, 3}, any.vector(), any.vector(), 1.2, 3.0, {}}; }},
    {"HelixAllMoves", [](Random& any) {
       return Helices{"", {0, 3}, any.moving_vector(), any.vector(), 1.2, -4.0,
                      std::vector{any.length(), any.length()}}; }},
    {"FormulaRod", [](Random&) {
       return UserConstraints{"", {{0, 1}, {5, 2}, {3, 1}},
                              formula_constraint("sqrt((x2-x1)^2 + (y2-y1)^2 + (z2-z1)^2) - 1.2", 2)}; }},
    {"FormulaMovingSurface", [](Random&) {
       return UserConstraints{"", {{0}, {4}}, formula_constraint("x1^2+y1^2-(1+0.1*sin(3*t))^2", 1)}; }},
    {"UserThreePoints", [](Random&) {
       return UserConstraints{"", {{0, 1, 2}, {3, 5, 4}}, make_constraint_kernel<3>([](const auto& x, const auto& now) {
         return exp(0.3 * x[0]) * cos(x[4] - now) + x[2] * x[8] * x[5] - atan2(x[7], 3.0 + x[6] * x[1]) + x[3]; })}; }},
};
// clang-format on

/// A random state far from xi = 0, for values and derivatives are defined everywhere.
struct Scene {
  System system;
  std::vector<double> r, v, w;
};

inline Scene make_scene(const Kind& kind, unsigned seed) {
  Random any(seed);
  Scene scene;
  scene.system.positions = any.numbers(18);
  scene.system.masses.assign(6, 1.0);
  scene.system.supports = {{"", {5}, {}}};
  scene.system.constraints = {kind.make(any)};
  scene.r = any.numbers(18);
  scene.v = any.numbers(18);
  scene.w = any.numbers(18);
  return scene;
}

/// The library's results in the user's order.
class Evaluated {
 public:
  explicit Evaluated(const Scene& scene, int threads = 1)
      : numbering_(number(scene.system)),
        constraints_(scene.system, numbering_),
        parallel_(threads),
        r_(inner(scene.r)),
        v_(inner(scene.v)),
        w_(inner(scene.w)) {
    constraints_.set_time(t);
    constraints_.choose_frames();
  }

  Eigen::VectorXd xi() {
    return rows([&](double* y) { worst = constraints_.evaluate_values(parallel_, r_.data(), y); });
  }
  Eigen::VectorXd rate() {
    return rows([&](double* y) { worst = constraints_.evaluate_rates(parallel_, r_.data(), v_.data(), y); });
  }
  /// Returns phi + K'w, and writes the blocks.
  Eigen::VectorXd right_side() {
    blocks.assign(3 * constraints_.num_blocks(), 0.0);
    return rows([&](double* y) {
      worst = constraints_.evaluate_right_side(parallel_, r_.data(), v_.data(), w_.data(), y, blocks.data());
    });
  }
  Eigen::VectorXd right_side_alone() {
    return rows([&](double* y) {
      worst = constraints_.evaluate_right_side(parallel_, r_.data(), v_.data(), w_.data(), y, nullptr);
    });
  }
  /// Returns K'w + shift from the blocks.
  Eigen::VectorXd transposed_times_w(double shift) {
    const std::vector<double> shifts(constraints_.num_rows(), shift);
    return rows([&](double* y) {
      worst = constraints_.apply_transposed(parallel_, blocks.data(), w_.data(), shifts.data(), y);
    });
  }
  /// Returns |xi|/|gradient|/length and |rate|/|gradient|.
  std::pair<Eigen::VectorXd, Eigen::VectorXd> measures() {
    Eigen::VectorXd velocity;
    const Eigen::VectorXd position =
        rows([&](double* x) { velocity = rows([&](double* y) { constraints_.measure(r_.data(), v_.data(), x, y); }); });
    return {position, velocity};
  }

  std::vector<double> gradients() {
    std::vector<double> result(3 * constraints_.num_blocks());
    constraints_.evaluate_gradients(parallel_, r_.data(), result.data());
    return result;
  }

  std::vector<double> squared_norms() const { return constraints_.squared_gradient_norms(); }

  /// Returns K, 3n x d, from the blocks of `right_side`.
  Eigen::MatrixXd K() const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(18, static_cast<Eigen::Index>(constraints_.num_rows()));
    for (const Incidence& incidence : constraints_.list_incidences()) {
      const Index point = numbering_.user_point[static_cast<std::size_t>(incidence.point)];
      const Index row = numbering_.user_row[static_cast<std::size_t>(incidence.row)];
      result.block<3, 1>(3 * point, row) += incidence.sign * reference::point(blocks, incidence.block);
    }
    return result;
  }

  double worst = 0.0;  ///< the result of the last call
  std::vector<double> blocks;

 private:
  std::vector<double> inner(const std::vector<double>& user) const {
    std::vector<double> result(user.size());
    numbering_.gather_points(user, result);
    return result;
  }

  template <class Fill>
  Eigen::VectorXd rows(const Fill& fill) const {
    std::vector<double> inner_rows(constraints_.num_rows(), NAN), user(constraints_.num_rows());
    fill(inner_rows.data());
    numbering_.scatter_rows(inner_rows, user);
    return reference::vector(user);
  }

  Numbering numbering_;
  Constraints constraints_;
  Parallel parallel_;
  std::vector<double> r_, v_, w_;
};

}  // namespace tanor::constraint_scenes
