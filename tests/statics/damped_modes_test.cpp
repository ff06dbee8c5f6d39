#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <string>

#include <tanor/kernel.hpp>
#include <tanor/modes.hpp>

#include "errors.hpp"
#include "scenes.hpp"
#include "statics/damped_modes.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"

namespace tanor {
using namespace detail;
namespace {

using scenes::g;
using std::numbers::pi;

/// Makes beads of 0.1 kg on rods of 0.1 m from a support.
System make_held_chain(int rods, const Vector3& rod) {
  System system = scenes::make_chain_along(rods, rod);
  system.supports = {Support{"", {0}}};
  return system;
}

std::vector<Index> beads(int rods) {
  std::vector<Index> result;
  for (int i = 1; i <= rods; ++i) result.push_back(i);
  return result;
}

/// Every bead of mass m has a drag of c, so that lambda^2 + (c/m) lambda + omega^2 = 0 with the undamped omega.
TEST(DampedModes, FollowFromTheUndampedOnesForAChainInAir) {
  for (const double c : {0.0, 0.3, 1.2, 8.0}) {
    System system = make_held_chain(6, {0.0, 0.0, -0.1});
    system.forces = {Gravity{"", {0.0, 0.0, -g}}};
    const Modes without = modes(system, system.positions, {.count = ModesOptions::all});
    if (c > 0.0) system.forces.push_back(Drag{.name = "air", .points = beads(6), .linear = c});

    const Modes found = modes(system, system.positions, {.count = 1000, .damped = true});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    std::vector<std::complex<double>> expected;
    for (const double omega : without.omega) {
      const double half = 0.5 * c / 0.1, rest = omega * omega - half * half;
      if (rest >= 0.0) {
        expected.push_back({-half, std::sqrt(rest)});
      } else {
        for (const double sign : {-1.0, 1.0}) expected.push_back({-half + sign * std::sqrt(-rest), 0.0});
      }
    }
    std::ranges::sort(expected, {}, [](const std::complex<double>& x) { return std::abs(x); });
    ASSERT_EQ(found.count(), expected.size());
    ASSERT_EQ(found.decay.size(), expected.size());
    const double largest = std::abs(expected.back());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      EXPECT_NEAR(std::hypot(found.omega[k], found.decay[k]), std::abs(expected[k]), 1e-10 * largest) << c;
      const auto nearest = std::ranges::min(expected, {}, [&](const std::complex<double>& x) {
        return std::abs(x - std::complex<double>(-found.decay[k], found.omega[k]));
      });
      EXPECT_NEAR(found.omega[k], nearest.imag(), 1e-10 * largest);
      EXPECT_NEAR(found.decay[k], -nearest.real(), 1e-10 * largest);
    }
    EXPECT_EQ(found.unstable_directions, 0u);
    EXPECT_LT(found.residual_max, 1e-12);
    EXPECT_EQ(found.shapes_imaginary.size(), found.shapes.size());
    EXPECT_TRUE(found.left_out.empty());
  }
}

/// The equations are those of `FollowFromTheUndampedOnesForAChainInAir` for 5,000 freedoms. Beads with springs on a
/// line between supports have omega^2 = (2 sqrt(k/m) sin(j pi/(2(N + 1))))^2, and each lambda solves lambda^2 +
/// (c/m) lambda + omega^2 = 0.
TEST(DampedModes, HaveTheClosedFormForALongChainOfSprings) {
  constexpr int count = 5000, wanted = 12;
  constexpr double stiffness = 3.0e6, mass = 0.1, drag = 1.3;
  System system;
  Springs springs{.name = "springs", .stiffness = stiffness};
  springs.rest_length = 0.09;
  for (int i = 0; i <= count + 1; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i, 0.0, 0.0});
    system.masses.push_back(mass);
    if (i > 0) springs.pairs.push_back({i - 1, i});
  }
  system.supports = {Support{"", {0, count + 1}}};
  system.constraints = {Lines{"line", beads(count), Vector3{0, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {springs, Drag{.name = "air", .points = beads(count), .linear = drag}};
  std::vector<std::complex<double>> expected;
  for (int j = 1; j <= wanted; ++j) {
    const double omega = 2.0 * std::sqrt(stiffness / mass) * std::sin(0.5 * j * pi / (count + 1)),
                 half = 0.5 * drag / mass;
    if (omega < half) {
      for (const double sign : {-1.0, 1.0}) expected.push_back(-half + sign * std::sqrt(half * half - omega * omega));
    } else {
      expected.push_back({-half, std::sqrt(omega * omega - half * half)});
    }
  }
  std::ranges::sort(expected, {}, [](const std::complex<double>& x) { return std::abs(x); });

  const Modes found = modes(system, system.positions, {.count = wanted, .damped = true, .solver = {.threads = 1}});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.count(), static_cast<std::size_t>(wanted));
  for (std::size_t k = 0; k < wanted; ++k) {
    EXPECT_NEAR(found.decay[k], -expected[k].real(), 1e-9 * std::abs(expected[k])) << k;
    EXPECT_NEAR(found.omega[k], expected[k].imag(), 1e-9 * std::abs(expected[k])) << k;
  }
  EXPECT_LT(found.residual_max, 1e-6);
}

/// Equal chains swing in air with a follower force. The sparse method solves their many freedoms, and the dense one,
/// which takes up to 300, solves the same equations for one chain.
TEST(DampedModes, AreThoseOfTheirPartsBeyond300Freedoms) {
  const auto make = [](int rods, int chains) {
    System system;
    Rods all{.name = "rods"};
    std::vector<std::vector<Index>> ends;
    std::vector<Index> moving, tops;
    for (int c = 0; c < chains; ++c) {
      const Index first = static_cast<Index>(system.num_points());
      tops.push_back(first);
      for (int i = 0; i <= rods; ++i) {
        system.positions.insert(system.positions.end(), {1.0 * c, 0.0, -0.1 * i});
        system.masses.push_back(0.1);
        if (i == 0) continue;
        all.pairs.push_back({first + i - 1, first + i});
        moving.push_back(first + i);
      }
      ends.push_back({first, first + rods});
    }
    system.supports = {Support{"", tops}};
    system.constraints = {all};
    // The force is perpendicular to the line from the support and has no potential.
    system.forces = {Gravity{"", {0.0, 0.0, -g}}, Drag{.name = "air", .points = moving, .linear = 0.02},
                     FormulaForce{.name = "vortex",
                                  .kernel = formula_tuple_force(
                                      std::vector<std::string>{"0", "0", "0", "-0.4*(y2-y1)", "0.4*(x2-x1)", "0"}),
                                  .tuples = ends}};
    return system;
  };
  const System one = make(60, 1), four = make(60, 4);

  const Modes dense = modes(one, one.positions, {.count = 6, .damped = true}),
              sparse = modes(four, four.positions, {.count = 24, .damped = true, .solver = {.threads = 1}});

  ASSERT_TRUE(dense.outcome.ok()) << dense.outcome.what;
  ASSERT_TRUE(sparse.outcome.ok()) << sparse.outcome.what;
  ASSERT_GT(sparse.degrees_of_freedom, 300u);
  for (std::size_t k = 0; k < 24; ++k) {
    const std::complex<double> own{-sparse.decay[k], sparse.omega[k]}, other{-dense.decay[k / 4], dense.omega[k / 4]};
    EXPECT_NEAR(std::abs(own - other), 0.0, 1e-9 * std::abs(other)) << k;
  }
  EXPECT_LT(sparse.residual_max, 1e-9);
}

/// One system, a chain of unequal beads in air with a follower force, is solved by its full dense matrix and by
/// Arnoldi's method on the sparse one.
TEST(DampedModes, AreTheSameFromDenseAndFromSparseMatrices) {
  constexpr int rods = 120, wanted = 30;
  System system = make_held_chain(rods, {0.0, 0.0, -0.1});
  for (std::size_t i = 0; i < system.num_points(); ++i)
    system.masses[i] = 0.1 + 0.05 * std::sin(static_cast<double>(i));
  system.forces = {Gravity{"", {0.0, 0.0, -g}}, Drag{.name = "air", .points = beads(rods), .linear = 0.02},
                   FormulaForce{.name = "vortex",
                                .kernel = formula_tuple_force(
                                    std::vector<std::string>{"0", "0", "0", "-0.4*(y2-y1)", "0.4*(x2-x1)", "0"}),
                                .tuples = {{0, rods}}}};
  const auto state = GivenEquilibrium::stand_at(system, {system.positions, {}, 1e-6}, {.solver = {.threads = 1}});
  KktSolver kkt(state->equations());
  ModeFinder finder(state->equations(), kkt, state->degrees_of_freedom());
  ASSERT_EQ(state->degrees_of_freedom(), 2u * rods);
  const Eigen::SparseMatrix<double> damping =
      state->equations().stiffness().find_damping(0.0, state->positions().data());
  const double rate = std::sqrt(finder.scale());

  const DampedModeSet dense = find_damped_modes(state->equations(), damping, *finder.find_basis(), 1e-6 * rate);
  const DampedModeSet sparse =
      find_lowest_damped_modes(state->equations(), damping, wanted, state->degrees_of_freedom(), rate, 1e-6 * rate);

  ASSERT_TRUE(sparse.outcome.ok()) << sparse.outcome.what;
  ASSERT_GE(sparse.lambda.size(), wanted);
  for (Eigen::Index k = 0; k < wanted; ++k)
    EXPECT_NEAR(std::abs(sparse.lambda[k] - dense.lambda[k]), 0.0, 1e-9 * std::abs(dense.lambda[k])) << k;
}

/// Two beads slide on a line with a spring and its damper between them: one slides freely, one swings with the reduced
/// mass.
TEST(DampedModes, HaveTheReducedMassForASpringWithADamper) {
  System system;
  system.positions = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0};
  system.masses = {1.0, 3.0};
  system.constraints = {Lines{"line", {0, 1}, Vector3{0, 0, 0}, Vector3{1, 0, 0}}};
  system.forces = {Springs{"spring", {{0, 1}}, 12.0, 0.6, 1.0}};

  const Modes found = modes(system, system.positions, {.damped = true});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.count(), 3u);
  EXPECT_EQ(found.zero_modes, 2u);  // lambda = 0 is a double root
  const double mass = 0.75, decay = 0.5 * 0.6 / mass;
  EXPECT_NEAR(found.decay[2], decay, 1e-12);
  EXPECT_NEAR(found.omega[2], std::sqrt(12.0 / mass - decay * decay), 1e-12);
}

/// Makes Ziegler's column: two rods, clamped springs of k = 1 N m at both joints, masses 2m and m, a force P along the
/// last rod. It flutters from P = (7/2 - sqrt 2) k/l on. No energy shows that, since P has no potential.
System make_zieglers_column(double push) {
  System system = make_held_chain(3, {0.1, 0.0, 0.0});
  system.supports = {Support{"", {0, 1}}};
  system.masses = {1.0, 1.0, 2.0, 1.0};
  const std::string along = std::to_string(-push) + "/sqrt((x2-x1)^2+(y2-y1)^2+(z2-z1)^2)*";
  const std::vector<std::string> follower{"0", "0", "0", along + "(x2-x1)", along + "(y2-y1)", along + "(z2-z1)"};
  system.forces = {Bendings{"joints", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::Cosine, 1.0, pi},
                   FormulaForce{.name = "follower", .kernel = formula_tuple_force(follower), .tuples = {{2, 3}}}};
  return system;
}

TEST(DampedModes, ShowZieglersColumnFlutterFromItsCriticalLoadOn) {
  const double critical = (3.5 - std::sqrt(2.0)) / 0.1;
  for (const double part : {0.5, 0.999, 1.001, 1.2}) {
    const System system = make_zieglers_column(part * critical);
    const Modes refused = modes(system, system.positions, {.count = ModesOptions::all});
    EXPECT_NE(refused.outcome.what.find("not conservative"), std::string::npos) << refused.outcome.what;

    const Modes found = modes(system, system.positions, {.count = ModesOptions::all, .damped = true});

    ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
    // There are two swings in both planes, or one that grows and one that decays.
    ASSERT_EQ(found.count(), 4u);
    EXPECT_EQ(found.unstable_directions, part < 1.0 ? 0u : 2u) << part;
    if (part < 1.0) continue;
    EXPECT_GT(found.omega[0], 0.0);
    EXPECT_NEAR(found.decay[0] + found.decay[1] + found.decay[2] + found.decay[3], 0.0, 1e-9 * found.omega[0]);
  }
}

/// The roots of x'' = -10 x + 3 y - 2 v_x + v_y, y'' = x - 4 y - v_y are those of a polynomial of degree 4.
TEST(DampedModes, AreRootsOfThePolynomialForUnsymmetricMatrices) {
  System system;
  system.positions = {0.0, 0.0, 0.0};
  system.masses = {1.0};
  system.constraints = {Planes{"paper", {0}, Vector3{0, 0, 1}, 0.0}};
  system.forces = {FormulaForce{.points = {0}, .kernel = formula_force({"3*y-10*x-2*vx+vy", "x-4*y-vy", "0"})}};

  const Modes found = modes(system, system.positions, {.damped = true});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.count(), 2u);
  for (std::size_t k = 0; k < 2; ++k) {
    const std::complex<double> s(-found.decay[k], found.omega[k]);
    const std::complex<double> polynomial = (s * s + 2.0 * s + 10.0) * (s * s + s + 4.0) - (3.0 + s) * 1.0;
    EXPECT_LT(std::abs(polynomial), 1e-11);
    EXPECT_GT(s.imag(), 0.0);
    const std::complex<double> x(found.shape(k)[0], found.shapes_imaginary[3 * k]),
        y(found.shape(k)[1], found.shapes_imaginary[3 * k + 1]);
    EXPECT_LT(std::abs((s * s + s + 4.0) * y - x), 1e-12);
    EXPECT_NEAR(std::norm(x) + std::norm(y), 1.0, 1e-12);
  }
}

/// A bead of 1 kg lies on a plane in air of 2 N s/m: lambda = 0 and -2 along each axis, and no stiffness sets a scale
/// of time.
TEST(DampedModes, DecayByDragAloneWhereNothingIsStiff) {
  System system;
  scenes::add_point({0.0, 0.0, 0.0}, &system);
  system.masses = {1.0};
  system.constraints = {Planes{.name = "table", .points = {0}, .normal = Vector3{0.0, 0.0, 1.0}}};
  system.forces = {Gravity{"", {0.0, 0.0, -g}}, Drag{.name = "air", .points = {0}, .linear = 2.0}};

  const Modes found = modes(system, system.positions, {.count = 4, .damped = true});

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  ASSERT_EQ(found.decay.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(found.decay[k], k < 2 ? 0.0 : 2.0, 1e-12);
    EXPECT_EQ(found.omega[k], 0.0);
  }
  EXPECT_EQ(found.zero_modes, 2u);
}

}  // namespace
}  // namespace tanor
