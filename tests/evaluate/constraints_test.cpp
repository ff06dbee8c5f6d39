/// Every kind of constraint against its definition over jets: xi, K'v + xi_t, phi and the blocks of K.

#include "evaluate/constraints.hpp"

#include <cmath>
#include <functional>
#include <optional>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include "base/parallel.hpp"
#include "evaluate/definitions.hpp"
#include "reference.hpp"
#include "system/members.hpp"
#include "system/neighbourhoods.hpp"

namespace tanor {
namespace {

constexpr double t = 0.7;

/// Random numbers of one test.
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
  /// Positive and smooth.
  ScalarFunction length() {
    const double mean = number(1.0, 2.0), rate = number(0.5, 3.0);
    return ScalarFunction::custom([=](const Jet<2>& s) { return mean + 0.5 * sin(rate * s); });
  }
  VectorFunction moving_vector() { return {length(), length(), length()}; }

 private:
  std::mt19937 generator_;
};

/// A kind with one way to give its parameters. Six points, the last one a support.
struct Kind {
  const char* name;
  std::function<Constraint(Random&)> make;

  friend std::ostream& operator<<(std::ostream& out, const Kind& kind) { return out << kind.name; }
};

// clang-format off
const Kind kinds[] = {
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
       return Ellipsoids{"", {1, 4}, any.vector(), {1.5, 0.8, 1.1}, any.vector(), any.vector()}; }},
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

/// A random state, far from xi = 0: values and derivatives are defined everywhere.
struct Scene {
  System system;
  std::vector<double> r, v, w;
};

Scene make_scene(const Kind& kind, unsigned seed) {
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

/// What the library says, in the user's order.
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
  /// phi + K'w, and the blocks with it.
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
  /// K'w + shift from the blocks.
  Eigen::VectorXd transposed_times_w(double shift) {
    const std::vector<double> shifts(constraints_.num_rows(), shift);
    return rows([&](double* y) {
      worst = constraints_.apply_transposed(parallel_, blocks.data(), w_.data(), shifts.data(), y);
    });
  }
  /// |xi|/|gradient|/length and |rate|/|gradient|.
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

  /// 3n x d, put together from the blocks of `right_side`.
  Eigen::MatrixXd K() const {
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(18, static_cast<Eigen::Index>(constraints_.num_rows()));
    for (const Incidence& incidence : constraints_.list_incidences()) {
      const Index point = numbering_.user_point[static_cast<std::size_t>(incidence.point)];
      const Index row = numbering_.user_row[static_cast<std::size_t>(incidence.row)];
      result.block<3, 1>(3 * point, row) += incidence.sign * reference::point(blocks, incidence.block);
    }
    return result;
  }

  double worst = 0.0;  ///< what the last call returned
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

void expect_close(const Eigen::VectorXd& computed, const Eigen::VectorXd& expected, double scale = 1.0) {
  ASSERT_EQ(computed.size(), expected.size());
  for (Eigen::Index a = 0; a < expected.size(); ++a) {
    EXPECT_NEAR(computed[a], expected[a], 1e-12 * std::max(scale, std::abs(expected[a]))) << "row " << a;
  }
}

class ConstraintKind : public testing::TestWithParam<Kind> {
 protected:
  /// Random scenes without short distances: there the derivatives grow, and rounding with them.
  template <class Check>
  void for_random_scenes(const Check& check) const {
    int scenes = 0;
    for (unsigned seed = 0; scenes < 50; ++seed) {
      const Scene scene = make_scene(GetParam(), seed);
      const auto expected = reference::evaluate_constraints(scene.system, t, scene.r, scene.v);
      if (expected.phi.cwiseAbs().maxCoeff() > 100.0) continue;
      ++scenes;
      SCOPED_TRACE("seed " + std::to_string(seed));
      check(scene, expected);
    }
  }
};

TEST_P(ConstraintKind, ValueIsItsDefinition) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    expect_close(Evaluated(scene).xi(), expected.xi);
  });
}

TEST_P(ConstraintKind, RateIsTheFirstDerivativeAlongTheMotion) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    expect_close(Evaluated(scene).rate(), expected.rate);
  });
}

TEST_P(ConstraintKind, GradientsAreTheDerivativesInEachCoordinate) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Evaluated evaluated(scene);

    (void)evaluated.right_side();

    EXPECT_LE((evaluated.K() - expected.K).cwiseAbs().maxCoeff(), 1e-13 * std::max(1.0, expected.K.norm()));
    EXPECT_EQ(evaluated.gradients(), evaluated.blocks);
  });
}

TEST_P(ConstraintKind, RightSideIsTheSecondDerivativeAlongTheMotionPlusKTransposedW) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const Eigen::VectorXd Kw = expected.K.transpose() * reference::vector(scene.w);
    // |v|^2/distance, the largest of the terms that phi is the sum of
    const double terms = std::max(10.0, expected.phi.cwiseAbs().maxCoeff());
    Evaluated evaluated(scene);

    const Eigen::VectorXd with_blocks = evaluated.right_side(), without = evaluated.right_side_alone();

    expect_close(with_blocks, expected.phi + Kw, terms);
    EXPECT_EQ(with_blocks, without);
  });
}

TEST_P(ConstraintKind, StoredBlocksGiveKTransposedTimesAVector) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Evaluated evaluated(scene);
    (void)evaluated.right_side();

    const Eigen::VectorXd y = evaluated.transposed_times_w(0.25);

    expect_close(y, (expected.K.transpose() * reference::vector(scene.w)).array() + 0.25, 10.0);
  });
}

TEST_P(ConstraintKind, SquaredNormsOfTheBlocksAreKnownWhereTheyNeverChange) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers&) {
    Evaluated evaluated(scene);

    const std::vector<double> squares = evaluated.squared_norms();

    const std::vector<double> blocks = evaluated.gradients();
    for (std::size_t k = 0; k < squares.size(); ++k) {
      EXPECT_NEAR(reference::point(blocks, static_cast<Index>(k)).squaredNorm(), squares[k], 1e-14 * squares[k]);
    }
    const Constraint& constraint = scene.system.constraints[0];
    const bool changes = std::holds_alternative<Angles>(constraint) || std::holds_alternative<Ellipsoids>(constraint) ||
                         std::holds_alternative<Helices>(constraint) ||
                         std::holds_alternative<UserConstraints>(constraint);
    EXPECT_EQ(squares.size(), changes ? 0 : blocks.size() / 3);
  });
}

TEST_P(ConstraintKind, SecondDefinitionOfTheHouseSaysTheSame) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const auto d = static_cast<std::size_t>(expected.xi.size());
    const double terms = std::max(10.0, expected.phi.cwiseAbs().maxCoeff());
    const Definitions definitions(scene.system, 0.0);
    Evaluated evaluated(scene);
    const Eigen::VectorXd second = evaluated.right_side();
    std::vector<double> xi(d), rate(d), curvature(d), y(d), lambda(d), eta(18);
    for (std::size_t a = 0; a < d; ++a) lambda[a] = std::sin(1.0 + 2.0 * static_cast<double>(a));

    definitions.taylor(Parallel(1), t, scene.r, scene.v, scene.w, xi, rate, curvature);
    definitions.transposed(Parallel(1), t, scene.r, scene.w, y);
    definitions.reactions(t, scene.r, lambda, eta);

    ASSERT_EQ(definitions.num_rows(), d);
    expect_close(evaluated.xi(), reference::vector(xi));
    expect_close(evaluated.rate(), reference::vector(rate));
    expect_close(second, reference::vector(curvature), terms);
    expect_close(evaluated.transposed_times_w(0.0), reference::vector(y), 10.0);
    expect_close(evaluated.K() * reference::vector(lambda), reference::vector(eta), 10.0);
  });
}

/// The gradient is taken point by point: the length of its largest block. Bars: rod length, radius,
/// else the length of the neighbourhood.
double length_of(const Scene& scene, Eigen::Index row) {
  const Constraint& constraint = scene.system.constraints[0];
  const reference::Configuration now = reference::standing(scene.r, t);
  const reference::Configuration start = reference::standing(scene.system.positions, 0.0);
  const reference::Xi xi{now, start};
  const auto k = static_cast<std::size_t>(row);
  // parameter = measure - xi
  const auto parameter = [&]<class Group>(Group group, Parameter Group::*member, std::size_t index) {
    const double value = xi(group, index).back().value();
    group.*member = 0.0;
    return xi(group, index).back().value() - value;
  };
  if (const auto* rods = std::get_if<Rods>(&constraint)) return parameter(*rods, &Rods::length, k);
  if (const auto* spheres = std::get_if<Spheres>(&constraint)) return parameter(*spheres, &Spheres::radius, k);
  if (const auto* circles = std::get_if<Circles>(&constraint)) return parameter(*circles, &Circles::radius, k / 2);
  // Else the length of the neighbourhood of the row's first moving point.
  const Neighbourhoods around = find_neighbourhoods(scene.system, 0.0);
  std::size_t next = 0;
  double length = scene_size(scene.system);
  for_each_member(scene.system, [&](std::span<const Index> points, int rows) {
    for (int own_row = 0; own_row < rows; ++own_row, ++next) {
      for (std::size_t p = points.size(); next == k && p-- > 0;) {
        const Index own = around.of_point[static_cast<std::size_t>(points[p])];
        if (own >= 0) length = around.length[static_cast<std::size_t>(own)];
      }
    }
  });
  return length;
}

double largest_block(const Eigen::MatrixXd& K, Eigen::Index row) {
  double result = 0.0;
  for (Eigen::Index i = 0; i < K.rows(); i += 3) result = std::max(result, K.block<3, 1>(i, row).norm());
  return result;
}

TEST_P(ConstraintKind, ViolationIsTheValueOverGradientAndLength) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    Eigen::VectorXd position = expected.xi.cwiseAbs(), velocity = expected.rate.cwiseAbs();
    for (Eigen::Index a = 0; a < position.size(); ++a) {
      position[a] /= largest_block(expected.K, a) * length_of(scene, a);
      velocity[a] /= largest_block(expected.K, a);
    }
    Evaluated evaluated(scene);

    const auto [position_measure, velocity_measure] = evaluated.measures();

    expect_close(position_measure, position);
    expect_close(velocity_measure, velocity);
    (void)evaluated.xi();
    EXPECT_NEAR(evaluated.worst, position.maxCoeff(), 1e-12 * std::max(1.0, position.maxCoeff()));
    (void)evaluated.rate();
    EXPECT_NEAR(evaluated.worst, velocity.maxCoeff(), 1e-12 * std::max(1.0, velocity.maxCoeff()));
  });
}

TEST_P(ConstraintKind, ResidualsAreReportedOverTheGradient) {
  for_random_scenes([](const Scene& scene, const reference::ConstraintNumbers& expected) {
    const auto worst_of = [&](const Eigen::VectorXd& rows) {
      double worst = 0.0;
      for (Eigen::Index a = 0; a < rows.size(); ++a) {
        worst = larger(worst, std::abs(rows[a]) / largest_block(expected.K, a));
      }
      return worst;
    };
    Evaluated evaluated(scene);

    const double right_side = worst_of(evaluated.right_side());
    const double right_side_reported = evaluated.worst;
    const double residual = worst_of(evaluated.transposed_times_w(-0.5));

    EXPECT_NEAR(right_side_reported, right_side, 1e-12 * right_side);
    EXPECT_NEAR(evaluated.worst, residual, 1e-12 * std::max(1.0, residual));
  });
}

INSTANTIATE_TEST_SUITE_P(Evaluate, ConstraintKind, testing::ValuesIn(kinds),
                         [](const auto& kind) { return std::string(kind.param.name); });

// ---- a line's two distances --------------------------------------------------------------------------------------

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

/// Point 0 on a line whose direction turns, seen step by step.
class TurningLine {
 public:
  explicit TurningLine(const VectorFunction& direction, double start = 0.0) {
    system_.positions = {0.3, -0.4, 0.5};
    system_.masses = {1.0};
    system_.constraints = {Lines{"", {0}, Vector3{0.1, 0.2, -0.3}, direction}};
    constraints_.emplace(system_, number(system_), start);
  }

  /// e1, e2
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

  /// xi, d xi/dt and d2 xi/dt2 of the point that stands still.
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

/// Around an axis; past two axes; through the axis that is farthest at the start, which must be given up.
const std::array turns = {formulas("cos(t)", "sin(t)", "5"), formulas("cos(t)", "0.1", "sin(t)"),
                          formulas("cos(t)", "sin(t)", "0.01*t"), formulas("cos(t)", "0.02", "0.01 + sin(t)")};

/// The axis that e1 comes from: the one that d is farthest from, of equal ones the first.
int axis_of(const Eigen::Vector3d& d) {
  int best = 0;
  for (const int k : {1, 2}) {
    if (std::abs(d[k]) < std::abs(d[best]) - 1e-6) best = k;
  }
  return best;
}

TEST(LineConstraint, ItsPairIsAFunctionOfTheDirectionAloneWhateverTimesAreSeen) {
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
  // From the axis that was chosen in the middle, which stays at all five places.
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

// ---- what the whole knows about itself ---------------------------------------------------------------------------

class Knowledge : public testing::Test {
 protected:
  static Constraints constraints_of(const char* kind) {
    for (const Kind& candidate : kinds) {
      if (std::string(candidate.name) != kind) continue;
      const Scene scene = make_scene(candidate, 1);
      return {scene.system, number(scene.system)};
    }
    throw std::logic_error(kind);
  }
};

TEST_F(Knowledge, DependenceOnTimeIsFound) {
  for (const char* kind : {"RodMovingLength", "RodWithOffsetAndMovingLength", "PlaneMovingOffset", "PlaneMovingNormal",
                           "SphereMovingCenterAndRadius", "LineMovingOrigin", "LineMovingDirection",
                           "CircleMovingCenter", "CircleMovingNormal", "AngleMovingCosine", "PulleyMovingLength",
                           "LinearMovingValue", "FormulaMovingSurface", "UserThreePoints"}) {
    EXPECT_TRUE(constraints_of(kind).depends_on_time()) << kind;
  }
  for (const char* kind : {"RodInitial", "RodWithOffset", "Plane", "Sphere", "Line", "Circle", "Angle", "Pulley",
                           "LinearOnePoint", "FormulaRod"}) {
    EXPECT_FALSE(constraints_of(kind).depends_on_time()) << kind;
  }
}

TEST_F(Knowledge, GradientsAreConstantOnPlanesLinesAndLinearConstraintsThatDoNotTurn) {
  for (const char* kind : {"Plane", "PlaneMovingOffset", "Line", "LineMovingOrigin", "LinearMovingValue"}) {
    EXPECT_TRUE(constraints_of(kind).gradients_are_constant()) << kind;
  }
  for (const char* kind : {"RodInitial", "PlaneMovingNormal", "Sphere", "LineMovingDirection", "Circle", "Angle",
                           "Pulley", "FormulaRod"}) {
    EXPECT_FALSE(constraints_of(kind).gradients_are_constant()) << kind;
  }
}

TEST_F(Knowledge, GradientNormsChangeWithAnglesUsersFunctionsAndKindsWithoutAKernel) {
  for (const Kind& kind : kinds) {
    const std::string name = kind.name;
    const bool changes = name.starts_with("Angle") || name.starts_with("Formula") || name.starts_with("User") ||
                         name.starts_with("Ellipsoid") || name.starts_with("Helix");
    EXPECT_EQ(constraints_of(kind.name).gradient_norms_are_constant(), !changes) << kind.name;
  }
}

// ---- time and threads --------------------------------------------------------------------------------------------

TEST(Constraints, GoingBackInTimeGivesTheSameBits) {
  const Scene scene = make_scene({"",
                                  [](Random& any) {
                                    return Spheres{"", {0}, any.moving_vector(), any.length()};
                                  }},
                                 5);
  const Numbering numbering = number(scene.system);
  Constraints constraints(scene.system, numbering);
  const auto xi_at = [&](double time) {
    double xi = NAN;
    constraints.set_time(time);
    (void)constraints.evaluate_values(Parallel(1), scene.r.data(), &xi);
    return xi;
  };

  const double first = xi_at(0.3), other = xi_at(1.9), again = xi_at(0.3);

  EXPECT_NE(first, other);
  EXPECT_EQ(first, again);
}

TEST(Constraints, TwoThreadsGiveTheSameBits) {
  // Enough members that each thread gets a range: a chain of 10,000 rods, angles along it, planes, sums of three
  // points.
  constexpr Index n = 10001;
  Random any(8);
  System system;
  for (Index i = 0; i < n; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i + any.number(), any.number(), any.number()});
  }
  system.masses.assign(n, 1.0);
  Rods rods{"", {}, 0.1, {}};
  Angles angles{"", {}, 0.2};
  Planes planes{"", {}, Vector3{0.1, 0.2, 0.9}, 0.3};
  Linears sums{"", {}, {any.vector(), any.vector(), any.vector()}, 0.1};
  for (Index i = 0; i + 2 < n; ++i) {
    rods.pairs.push_back({i, i + 1});
    angles.triples.push_back({i, i + 1, i + 2});
    planes.points.push_back(i);
    sums.tuples.push_back({i + 1, i, i + 2});
  }
  system.constraints = {rods, angles, planes, sums};
  const Numbering numbering = number(system);
  Constraints constraints(system, numbering);
  const std::vector<double> r = any.numbers(3 * n), v = any.numbers(3 * n), w = any.numbers(3 * n);
  struct Result {
    std::vector<double> xi, rate, phi, blocks, y;
    double worst[4];
    bool operator==(const Result&) const = default;
  };
  const auto evaluate = [&](int threads) {
    const Parallel parallel(threads);
    const std::size_t d = constraints.num_rows();
    Result result{std::vector<double>(d), std::vector<double>(d),
                  std::vector<double>(d), std::vector<double>(3 * constraints.num_blocks()),
                  std::vector<double>(d), {}};
    result.worst[0] = constraints.evaluate_values(parallel, r.data(), result.xi.data());
    result.worst[1] = constraints.evaluate_rates(parallel, r.data(), v.data(), result.rate.data());
    result.worst[2] = constraints.evaluate_right_side(parallel, r.data(), v.data(), w.data(), result.phi.data(),
                                                      result.blocks.data());
    result.worst[3] = constraints.apply_transposed(parallel, result.blocks.data(), w.data(), nullptr, result.y.data());
    return result;
  };

  const Result one = evaluate(1);

  for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == evaluate(threads)) << threads;
}

}  // namespace
}  // namespace tanor
