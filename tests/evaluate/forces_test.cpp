/// The tests compare active forces with formulas, potential energy with the forces, and power with force times
/// velocity.

#include "evaluate/forces.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "random_systems.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr Index num_points = 6;  // 4 and 5 are supports
constexpr Index num_moving = 4;

struct ForceScene {
  System system;
  std::vector<double> r, v;  // user's order
};

/// Makes points at random places and velocities without constraints. Supports 4 and 5 take part by their state.
ForceScene make_force_scene(std::vector<Force> forces, unsigned seed = 1) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> number(-1.0, 1.0);
  ForceScene scene;
  for (Index i = 0; i < num_points; ++i) {
    for (int k = 0; k < 3; ++k) {
      scene.system.positions.push_back(number(generator) + 2.0 * i);
      scene.r.push_back(scene.system.positions.back() + 0.5 * number(generator));
      scene.v.push_back(number(generator));
    }
    scene.system.masses.push_back(1.0 + 0.5 * i);
  }
  scene.system.supports = {{"", {4, 5}, {}}};
  scene.system.forces = std::move(forces);
  return scene;
}

/// Without constraints the inner order is the moving points as they are and the supports last, as the user's order
/// here.
class ForceTest : public testing::Test {
 protected:
  static Eigen::VectorXd forces_at(const ForceScene& scene, double t = 0.0) {
    Forces forces(scene.system, number(scene.system));
    std::vector<double> f(scene.r.size(), NAN);
    forces.evaluate(Parallel(1), t, scene.r.data(), scene.v.data(), f.data());
    return reference::vector(f);
  }

  static void expect_equal(const Eigen::VectorXd& computed, const Eigen::VectorXd& expected) {
    ASSERT_EQ(computed.size(), expected.size());
    for (Eigen::Index c = 0; c < expected.size(); ++c) {
      EXPECT_NEAR(computed[c], expected[c], 1e-14 * std::max(1.0, std::abs(expected[c]))) << "coordinate " << c;
    }
  }

  static Eigen::Vector3d on(const Eigen::VectorXd& f, Index i) { return f.segment<3>(3 * i); }
};

TEST_F(ForceTest, GravityIsMassTimesAccelerationAndLeavesSupportsAlone) {
  const ForceScene scene = make_force_scene({Gravity{"", {0.1, 0.0, -9.81}}, Gravity{"", {0.0, 2.0, 0.0}}});

  const Eigen::VectorXd f = forces_at(scene);

  for (Index i = 0; i < num_moving; ++i) {
    EXPECT_LE((on(f, i) - scene.system.masses[static_cast<std::size_t>(i)] * Eigen::Vector3d(0.1, 2.0, -9.81)).norm(),
              1e-14);
  }
  EXPECT_EQ(f.tail(6).norm(), 0.0);
}

TEST_F(ForceTest, GivenForcesAddUpAndFollowTime) {
  const auto swinging = ScalarFunction::formula("cos(2*t)");
  const ForceScene scene = make_force_scene(
      {ConstantForce{"", {1, 3}, Vector3{1.0, 2.0, 3.0}}, ConstantForce{"", {3}, VectorFunction(swinging, 0.0, 1.0)}});

  const Eigen::VectorXd f = forces_at(scene, 0.4);

  EXPECT_EQ(on(f, 0).norm(), 0.0);
  EXPECT_LE((on(f, 1) - Eigen::Vector3d(1.0, 2.0, 3.0)).norm(), 0.0);
  EXPECT_LE((on(f, 3) - Eigen::Vector3d(1.0 + std::cos(0.8), 2.0, 4.0)).norm(), 1e-15);
}

TEST_F(ForceTest, StretchedSpringPullsItsPointsTogether) {
  // Point 0 is at the origin and point 1 at (3, 4, 0). With length 5, rest length 2 and stiffness 10 the force is 30 N
  // along (0.6, 0.8, 0).
  ForceScene scene = make_force_scene({Springs{"", {{0, 1}}, 10.0, 0.0, 2.0}});
  scene.r = {0.0, 0.0, 0.0, 3.0, 4.0, 0.0, 9, 9, 9, 8, 8, 8, 7, 7, 7, 6, 6, 6};

  const Eigen::VectorXd f = forces_at(scene);

  EXPECT_LE((on(f, 0) - Eigen::Vector3d(18.0, 24.0, 0.0)).norm(), 1e-13);
  EXPECT_LE((on(f, 1) + Eigen::Vector3d(18.0, 24.0, 0.0)).norm(), 1e-13);
}

TEST_F(ForceTest, DampingActsAlongTheSpringOnly) {
  // The length along x grows by 2 m/s and the sideways velocity has no effect, so that c dL/dt = 0.5 * 2 = 1 N.
  ForceScene scene = make_force_scene({Springs{"", {{0, 1}}, 0.0, 0.5, 2.0}});
  scene.r = {0.0, 0.0, 0.0, 1.5, 0.0, 0.0, 9, 9, 9, 8, 8, 8, 7, 7, 7, 6, 6, 6};
  scene.v = {-1.0, 5.0, 0.0, 1.0, -3.0, 2.0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0};

  const Eigen::VectorXd f = forces_at(scene);

  EXPECT_LE((on(f, 0) - Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-15);
  EXPECT_LE((on(f, 1) + Eigen::Vector3d(1.0, 0.0, 0.0)).norm(), 1e-15);
}

TEST_F(ForceTest, SpringWithoutARestLengthGivenStartsUnstretched) {
  ForceScene scene = make_force_scene({Springs{"", {{0, 1}, {1, 5}}, 10.0, 0.0, {}}});
  scene.r = scene.system.positions;

  const Eigen::VectorXd f = forces_at(scene);

  EXPECT_LE(f.norm(), 1e-13);
}

TEST_F(ForceTest, SpringOfCoincidentPointsWithoutRestLengthPullsWithZeroForce) {
  ForceScene scene = make_force_scene({Springs{"", {{0, 1}}, 10.0, 1.0, 0.0}});
  std::copy_n(scene.r.begin(), 3, scene.r.begin() + 3);

  const Eigen::VectorXd f = forces_at(scene);

  EXPECT_EQ(f.norm(), 0.0);
}

TEST_F(ForceTest, DragIsLinearPlusQuadraticInTheVelocity) {
  // With |v| = 2 the force is -(1.5 + 0.25 * 2) v = -2 v.
  ForceScene scene = make_force_scene({Drag{"", {2}, 1.5, 0.25}});
  std::fill(scene.v.begin(), scene.v.end(), 1.0);
  std::copy_n(std::array{2.0, 0.0, 0.0}.begin(), 3, scene.v.begin() + 6);

  const Eigen::VectorXd f = forces_at(scene);

  expect_equal(on(f, 2), Eigen::Vector3d(-4.0, 0.0, 0.0));
  EXPECT_NEAR(f.norm(), 4.0, 1e-15);
}

TEST_F(ForceTest, FormulasActOnTheirPointsAndAddUp) {
  // A magnetic field of 2 T along z turns the velocity, 3 t along x pushes, and point 5 is a support.
  ForceScene scene = make_force_scene({FormulaForce{"", {1, 5}, formula_force({"2*vy", "-2*vx", "0"})},
                                       FormulaForce{"", {5, 1}, formula_force({"k*t", "y", "0"}, {{"k", 3.0}})}});

  const Eigen::VectorXd f = forces_at(scene, 0.5);

  for (const Index i : {1, 5}) {
    const Eigen::Vector3d r = reference::point(scene.r, i), v = reference::point(scene.v, i);
    EXPECT_EQ(on(f, i), Eigen::Vector3d(2.0 * v.y() + 1.5, -2.0 * v.x() + r.y(), 0.0));
  }
  EXPECT_EQ(on(f, 0).norm() + on(f, 2).norm() + on(f, 3).norm() + on(f, 4).norm(), 0.0);
}

// ---- all together, on random scenes ------------------------------------------------------------------------------

ForceScene any_scene(unsigned seed) {
  return make_force_scene({Gravity{"", {0.3, 0.1, -9.81}}, ConstantForce{"", {0, 2, 4}, Vector3{0.4, -1.0, 2.0}},
                           Springs{"", {{0, 1}, {2, 4}, {3, 1}, {5, 3}}, 7.0, 0.0, std::vector{0.5, 1.0, 2.0, 0.0}},
                           Springs{"", {{0, 2}}, 3.0, 0.0, {}}},
                          seed);
}

ForceScene any_dissipative_scene(unsigned seed) {
  ForceScene scene = any_scene(seed);
  scene.system.forces.push_back(Springs{"", {{1, 2}, {5, 0}, {4, 5}}, 2.0, 0.7, 1.0});
  scene.system.forces.push_back(Drag{"", {0, 3, 4}, 0.6, 0.2});
  const auto swinging = ScalarFunction::formula("3*sin(2*t)");
  scene.system.forces.push_back(ConstantForce{"", {1, 4}, VectorFunction(swinging, 0.5, swinging)});
  scene.system.forces.push_back(FormulaForce{"", {3, 0, 5}, formula_force({"vy - t*x", "-vx*z", "sin(x + y)"})});
  return scene;
}

TEST_F(ForceTest, AllKindsTogetherAgreeWithPlainFormulas) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    const ForceScene scene = any_dissipative_scene(seed);

    const Eigen::VectorXd f = forces_at(scene, 0.9);

    const Eigen::VectorXd expected = reference::evaluate_forces(scene.system, 0.9, scene.r, scene.v);
    EXPECT_LE((f - expected).norm(), 1e-14 * expected.norm()) << "seed " << seed;
  }
}

/// Returns the derivative at 0 of a function of one number, from differences of order 8.
template <class Function>
double derivative_at_zero(const Function& function, double h = 0.01) {
  constexpr double weights[] = {4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0};
  double sum = 0.0;
  for (int k = 1; k <= 4; ++k) sum += weights[k - 1] * (function(k * h) - function(-k * h));
  return sum / h;
}

TEST_F(ForceTest, ForcesOnMovingPointsAreMinusTheSlopeOfThePotential) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const ForceScene scene = any_scene(seed);
    Forces forces(scene.system, number(scene.system));
    const Eigen::VectorXd f = forces_at(scene);

    for (std::size_t c = 0; c < 3 * num_moving; ++c) {
      const double slope = derivative_at_zero([&](double e) {
        std::vector<double> r = scene.r;
        r[c] += e;
        return forces.potential(Parallel(1), 0.0, r.data());
      });

      EXPECT_NEAR(slope, -f[static_cast<Eigen::Index>(c)], 1e-9) << "seed " << seed << ", coordinate " << c;
    }
  }
}

TEST_F(ForceTest, PowerIsThatOfTheForcesWithoutPotential) {
  // f = conservative part + the rest. The conservative part alone comes from the same scene without the others.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const ForceScene scene = any_dissipative_scene(seed);
    const double t = 1.3;
    ForceScene conservative = scene;
    conservative.system.forces.resize(4);
    Springs elastic = std::get<Springs>(scene.system.forces[4]);
    elastic.damping = 0.0;
    conservative.system.forces.push_back(elastic);
    const Eigen::VectorXd rest = forces_at(scene, t) - forces_at(conservative, t);
    Forces forces(scene.system, number(scene.system));
    std::vector<double> f(scene.r.size());
    forces.evaluate(Parallel(1), t, scene.r.data(), scene.v.data(), f.data());

    const double power = forces.power(Parallel(1), scene.r.data(), scene.v.data());

    const double expected = rest.head(3 * num_moving).dot(reference::vector(scene.v).head(3 * num_moving));
    EXPECT_NEAR(power, expected, 1e-12 * std::max(1.0, std::abs(expected))) << "seed " << seed;
  }
}

TEST_F(ForceTest, PotentialGrowsByTheWorkOfMovingPointsAndOfSupports) {
  // dU/dt along v = -(conservative forces on moving points).v + power of the supports through springs.
  for (unsigned seed = 0; seed < 20; ++seed) {
    const ForceScene scene = any_scene(seed);
    Forces forces(scene.system, number(scene.system));
    const Eigen::VectorXd f = forces_at(scene), v = reference::vector(scene.v);

    const double rate = derivative_at_zero([&](double e) {
      const Eigen::VectorXd r = reference::vector(scene.r) + e * v;
      return forces.potential(Parallel(1), 0.0, r.data());
    });

    const double by_points = -f.head(3 * num_moving).dot(v.head(3 * num_moving));
    const double by_supports = forces.elastic_power_of_supports(Parallel(1), scene.r.data(), scene.v.data());
    EXPECT_NEAR(rate, by_points + by_supports, 1e-9) << "seed " << seed;
  }
}

TEST_F(ForceTest, ForcesSayWhetherTheyDoWorkAndDependOnVelocity) {
  struct Expectation {
    Force force;
    bool has_work, depends_on_velocity;
  };
  const auto swinging = ScalarFunction::formula("sin(t)");
  const Expectation expectations[] = {
      {Gravity{"", {0.0, 0.0, -1.0}}, false, false},
      {ConstantForce{"", {0}, Vector3{1.0, 0.0, 0.0}}, false, false},
      {ConstantForce{"", {0}, VectorFunction(swinging, 0.0, 0.0)}, true, false},
      {Springs{"", {{0, 1}}, 1.0, 0.0, 1.0}, false, false},
      {Springs{"", {{0, 1}}, 1.0, 0.1, 1.0}, true, true},
      {Drag{"", {0}, 1.0, 0.0}, true, true},
      {FormulaForce{"", {0}, formula_force({"-x", "0", "0"})}, true, false},
      {FormulaForce{"", {0}, formula_force({"0", "0", "vz*t"})}, true, true},
  };
  for (const Expectation& expectation : expectations) {
    const ForceScene scene = make_force_scene({expectation.force});

    const Forces forces(scene.system, number(scene.system));

    EXPECT_EQ(forces.has_work(), expectation.has_work) << kind_name(expectation.force);
    EXPECT_EQ(forces.depends_on_velocity(), expectation.depends_on_velocity) << kind_name(expectation.force);
  }
}

/// Makes springs, damping, several drags and given forces on the same points in a mixed order. The last points are
/// supports.
System make_large_system() {
  constexpr Index n = 9000;
  std::mt19937 generator(4);
  std::normal_distribution<double> number_of;
  System system;
  Springs springs{"", {}, 5.0, 0.1, 0.7};
  Drag drag{"", {}, 0.1, 0.2}, oil{"", {}, 0.7, 0.0};
  const auto swinging = ScalarFunction::formula("0.4*cos(t)");
  ConstantForce wind{"", {}, VectorFunction(swinging, 0.2, swinging)}, push{"", {}, Vector3{0.1, 0.2, 0.3}};
  for (Index i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      system.positions.push_back(number_of(generator));
      system.velocities.push_back(number_of(generator));
    }
    drag.points.push_back(i);
    wind.points.push_back(n - 1 - i);
    if (i % 3 == 0) push.points.push_back(i);
    if (i % 2 == 0) oil.points.push_back((7 * i) % n);
    if (i > 0) springs.pairs.push_back({i - 1, i});
    if (i > 10) springs.pairs.push_back({i, i - 10});
  }
  system.masses.assign(n, 0.3);
  system.supports = {{"", {n - 2, n - 1}, {}}};
  const FormulaForce field{"", drag.points, formula_force({"vy*sin(t)", "-vx*exp(-x^2)", "0.1*z"})};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, springs, drag, wind, oil, push, field};
  return system;
}

TEST_F(ForceTest, AnyNumberOfThreadsGivesTheSameBits) {
  const System system = make_large_system();
  const Numbering numbering = number(system);
  const double *r = system.positions.data(), *v = system.velocities.data();
  struct Result {
    std::vector<double> f;
    double potential, power, supports;
    bool operator==(const Result&) const = default;
  };
  const auto evaluate = [&](int threads) {
    const Parallel parallel(threads);
    Forces forces(system, numbering);
    Result result{std::vector<double>(system.positions.size(), NAN), 0.0, 0.0, 0.0};
    forces.evaluate(parallel, 0.3, r, v, result.f.data());
    result.potential = forces.potential(parallel, 0.0, r);
    result.power = forces.power(parallel, r, v);
    result.supports = forces.elastic_power_of_supports(parallel, r, v);
    return result;
  };

  const Result one = evaluate(1);

  EXPECT_TRUE(std::isfinite(one.potential + one.power + one.supports));
  for (const int threads : {2, 3, 5}) EXPECT_TRUE(one == evaluate(threads)) << threads;
}

TEST_F(ForceTest, LargeSystemsAgreeWithPlainFormulas) {
  const System system = make_large_system();
  Forces forces(system, number(system));
  std::vector<double> f(system.positions.size(), NAN);

  forces.evaluate(Parallel(3), 0.3, system.positions.data(), system.velocities.data(), f.data());

  const Eigen::VectorXd expected = reference::evaluate_forces(system, 0.3, system.positions, system.velocities);
  EXPECT_LE((reference::vector(f) - expected).lpNorm<Eigen::Infinity>(), 1e-12);
}

TEST_F(ForceTest, ForcesAndDragsOnOnePointAddUpInAnyOrderOfEntries) {
  // Point 2 at 2 m/s along x has 1 + 2 - (0.5 + 0.25) 2 = 1.5 N, and point 0 at rest has 2 N.
  ForceScene scene = make_force_scene({Drag{"", {3, 2}, 0.5, 0.0}, ConstantForce{"", {2}, Vector3{1.0, 0.0, 0.0}},
                                       Drag{"", {2}, 0.25, 0.0}, ConstantForce{"", {2, 0}, Vector3{2.0, 0.0, 0.0}}});
  std::fill(scene.v.begin(), scene.v.end(), 0.0);
  scene.v[6] = 2.0;

  const Eigen::VectorXd f = forces_at(scene);

  EXPECT_EQ(on(f, 2), Eigen::Vector3d(1.5, 0.0, 0.0));
  EXPECT_EQ(on(f, 0), Eigen::Vector3d(2.0, 0.0, 0.0));
  EXPECT_EQ(f.norm(), 2.5);
}

RC_GTEST_PROP(Forces, AgreeWithPlainFormulasOnRandomSystems, ()) {
  const RandomSystem random = any_system();
  const Numbering numbering = number(random.system);
  Forces forces(random.system, numbering);
  const std::size_t size = random.positions.size();
  std::vector<double> r(size), v(size), f(size), user(size);
  numbering.gather_points(random.positions, r);
  numbering.gather_points(random.velocities, v);

  forces.evaluate(Parallel(1), random.t, r.data(), v.data(), f.data());
  numbering.scatter_points(f, user);

  const Eigen::VectorXd expected =
      reference::evaluate_forces(random.system, random.t, random.positions, random.velocities);
  RC_ASSERT((reference::vector(user) - expected).norm() <= 1e-13 * (1.0 + expected.norm()));
}

}  // namespace
}  // namespace tanor
