/// Ropes that depend on each other: which of them carry, how they share a load, and impacts with several restitutions.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <Eigen/Core>
#include <tanor/motion.hpp>

#include "dense.hpp"
#include "measures.hpp"

namespace tanor {
namespace {

Simulation start(const System& system, Method method = Method::Dop853) {
  return Simulation(system, {.method = method, .rtol = 1e-11, .atol = 1e-12}, {.threads = 1});
}

std::vector<double> tensions(const Simulation& simulation) {
  std::vector<double> result;
  for (const double lambda : simulation.multipliers()) result.push_back(-lambda);
  return result;
}

/// A support and two masses of 3 and 1 kg on a line along x, and what joins them: 0-1, 1-2 and 0-2.
System make_line(std::vector<std::vector<Index>> paths, double g = 10.0) {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0};
  system.masses = {1, 3, 1};
  system.supports = {{.points = {0}}};
  system.constraints = {Ropes{.name = "ropes", .paths = std::move(paths)}};
  system.add_gravity({g, 0.0, 0.0});
  return system;
}

/// T01 - T12 = 30 N and T12 + T02 = 10 N. The least norm of all has T12 = -20/3 N; with the right signs T12 = 0.
TEST(DependentRopes, ForcesAreThoseOfLeastNormWithTheRightSigns) {
  const auto forces = [](std::vector<std::vector<Index>> paths, double g) {
    Simulation simulation = start(make_line(std::move(paths), g));
    EXPECT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
    return tensions(simulation);
  };
  EXPECT_LT(largest_difference(forces({{0, 1}, {1, 2}, {0, 2}}, 10.0), std::vector{30.0, 0.0, 10.0}), 1e-12);
  EXPECT_LT(largest_difference(forces({{0, 2}, {1, 2}, {0, 1}}, 10.0), std::vector{10.0, 0.0, 30.0}), 1e-12);
  EXPECT_LT(largest_difference(forces({{0, 1}, {1, 2}, {0, 2}}, -10.0), std::vector{0.0, 0.0, 0.0}), 1e-12);
}

/// The shorter one of two ropes on a line holds a point that swings, whatever their order is.
TEST(DependentRopes, TheLongerOneOfTwoRopesOnALineOpens) {
  for (const bool is_first : {true, false}) {
    System system;
    system.positions = {-1, 0, 0, 0, 0, 0, 1, 0, 0};
    system.velocities = {0, 0, 0, 0, 0, 0, 0, 2, 0};
    system.masses = {1, 1, 1};
    system.supports = {{.points = {0, 1}}};
    Ropes ropes{.name = "ropes", .paths = {{1, 2}, {0, 2}}};
    if (!is_first) std::swap(ropes.paths[0], ropes.paths[1]);
    system.constraints = {ropes};
    for (const Method method : {Method::Taylor, Method::Dop853}) {
      Simulation simulation = start(system, method);
      ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
      EXPECT_NEAR(simulation.accelerations()[6], -4.0, 1e-12);
      EXPECT_NEAR(tensions(simulation)[is_first ? 0 : 1], 4.0, 1e-12);
      EXPECT_EQ(tensions(simulation)[is_first ? 1 : 0], 0.0);
      const Outcome outcome = simulation.advance_to(1.0);
      ASSERT_TRUE(outcome.ok()) << outcome.what;
      EXPECT_NEAR(simulation.positions()[6], std::cos(2.0), 1e-9);
      EXPECT_NEAR(simulation.positions()[7], std::sin(2.0), 1e-9);
      EXPECT_TRUE(simulation.report().contact_events.empty());
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
    }
  }
}

/// A load across two ropes that rest, where both would do, makes the point swing on the shorter one: the other one is
/// open from the start, and nothing happens. What circles on another rope meanwhile changes nothing.
TEST(DependentRopes, TheLongerOneOpensAlsoWhereThePointRests) {
  for (const Method method : {Method::Taylor, Method::Dop853}) {
    for (const auto& [across, circles] : {std::pair{1.0, false}, {1e-3, false}, {1.0, true}}) {
      System system;
      system.positions = {-1, 0, 0, 0, 0, 0, 1, 0, 0};
      system.masses = {1, 1, 1};
      system.supports = {{.points = {0, 1}}};
      system.constraints = {Ropes{.name = "ropes", .paths = {{0, 2}, {1, 2}}}};
      system.forces = {ConstantForce{.points = {2}, .force = Vector3{3.0, across, 0.0}}};
      if (circles) {
        const Index other = system.add_point({.position = {0.0, 5.0, 0.0}, .velocity = {0.0, 0.0, 2.0}}).index;
        system.constraints.push_back(Ropes{.paths = {{0, other}}});
      }
      Simulation simulation = start(system, method);
      std::vector<double> T = tensions(simulation);
      T.resize(2);
      EXPECT_LT(largest_difference(T, std::vector{0.0, 3.0}), 1e-12);
      const Outcome outcome = simulation.advance_to(1.0);
      ASSERT_TRUE(outcome.ok()) << outcome.what;
      EXPECT_TRUE(simulation.report().contact_events.empty());
      EXPECT_NEAR(std::hypot(simulation.positions()[6], simulation.positions()[7]), 1.0, 1e-10);
      // Lengths to 1e-12 m are work of 3e-12 J, beside 5e-7 J of the slow one.
      EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), across < 1.0 ? 1e-6 : 1e-9);
      EXPECT_TRUE(simulation.certify().passed()) << simulation.certify().line();
    }
  }
}

/// Two links of a chain that moves sideways, and a rope over both: it is slack as soon as the chain bends.
TEST(DependentRopes, ARopeOverAChainThatBendsOpens) {
  System system = make_line({{0, 2}, {0, 1}, {1, 2}});
  system.velocities = {0, 0, 0, 0, 1, 0, 0, -1, 0};
  System chain = make_line({{0, 1}, {1, 2}});
  chain.velocities = system.velocities;
  Simulation all = start(system), two = start(chain);
  ASSERT_TRUE(all.outcome().ok()) << all.outcome().what;
  EXPECT_LT(largest_difference(all.accelerations(), two.accelerations()), 1e-12);
  EXPECT_EQ(tensions(all)[0], 0.0);
  for (Simulation* const each : {&all, &two}) ASSERT_TRUE(each->advance_to(0.1).ok());
  EXPECT_LT(largest_difference(all.positions(), two.positions()), 1e-10);
}

/// One or two points on more ropes than they have directions, some of them double: random loads.
struct ManyRopes {
  System system;
  Eigen::MatrixXd K;  // [moving numbers x ropes]: what each rope shortens
  Eigen::VectorXd force, inverse_mass;
};

ManyRopes make_many(std::mt19937& generator, double scale = 1.0) {
  std::uniform_real_distribution<double> number(-1.0, 1.0), mass(0.5, 2.0);
  ManyRopes made;
  const Index moving = std::uniform_int_distribution<Index>(1, 2)(generator), all = moving + 4;
  for (Index i = 0; i < all; ++i) {
    for (int c = 0; c < 3; ++c)
      made.system.positions.push_back(number(generator) + (i < moving ? 0.0 : 2.0 * (c == 2)));
    made.system.masses.push_back(scale * mass(generator));
    if (i >= moving) made.system.supports.push_back({.points = {i}});
  }
  made.force.resize(3 * moving);
  made.inverse_mass.resize(3 * moving);
  for (Index i = 0; i < moving; ++i) {
    const Vector3 f{scale * number(generator), scale * number(generator), scale * (3.0 * number(generator) - 2.0)};
    made.system.forces.push_back(ConstantForce{.points = {i}, .force = f});
    for (Index c = 0; c < 3; ++c) {
      made.force[3 * i + c] = f[static_cast<std::size_t>(c)];
      made.inverse_mass[3 * i + c] = 1.0 / made.system.masses[static_cast<std::size_t>(i)];
    }
  }
  Ropes ropes{.name = "ropes"};
  const int count = std::uniform_int_distribution<int>(4, 7)(generator);
  made.K.setZero(3 * moving, count);
  for (int k = 0; k < count; ++k) {
    const Index i = std::uniform_int_distribution<Index>(0, moving - 1)(generator);
    Index j = i;
    while (j == i) j = std::uniform_int_distribution<Index>(0, all - 1)(generator);
    ropes.paths.push_back({i, j});
    const auto at = [&](Index point) { return reference::place(made.system.positions, point); };
    const Eigen::Vector3d along = (at(j) - at(i)).normalized();
    made.K.col(k).segment<3>(3 * i) = along;
    if (j < moving) made.K.col(k).segment<3>(3 * j) = -along;
  }
  made.system.constraints = {ropes};
  return made;
}

/// Returns the tensions of least norm among all complementary ones, by trying all sets: a = M^-1 (f + K T) shortens no
/// rope that carries and lengthens none.
Eigen::VectorXd enumerate(const ManyRopes& made) {
  const auto count = static_cast<unsigned>(made.K.cols());
  double least = std::numeric_limits<double>::infinity();
  Eigen::VectorXd best;
  for (unsigned closed = 0; closed < 1u << count; ++closed) {
    std::vector<Eigen::Index> which;
    for (unsigned k = 0; k < count; ++k)
      if ((closed >> k & 1u) != 0) which.push_back(k);
    Eigen::VectorXd T = Eigen::VectorXd::Zero(count);
    if (!which.empty()) {
      const Eigen::MatrixXd K = made.K(Eigen::all, which);
      const Eigen::VectorXd right = -K.transpose() * made.inverse_mass.cwiseProduct(made.force);
      T(which) = reference::solve_least_squares(K.transpose() * made.inverse_mass.asDiagonal() * K, right, 1e-11);
    }
    const Eigen::VectorXd shortening = made.K.transpose() * made.inverse_mass.cwiseProduct(made.force + made.K * T);
    if (T.minCoeff() < -1e-10 || shortening.minCoeff() < -1e-9) continue;
    if (T.norm() < least - 1e-9) {
      least = T.norm();
      best = T;
    }
  }
  return best;
}

TEST(DependentRopes, RandomLoadsAreSharedAsByEnumeration) {
  std::mt19937 generator(3);
  int num_dependent = 0;
  for (int scene = 0; scene < 500; ++scene) {
    const ManyRopes made = make_many(generator);
    Simulation simulation = start(made.system);
    ASSERT_TRUE(simulation.outcome().ok()) << scene << ": " << simulation.outcome().what;
    const Eigen::VectorXd T = enumerate(made);
    ASSERT_GT(T.size(), 0);
    num_dependent += static_cast<int>((T.array() > 1e-6).count()) > made.K.rows();
    EXPECT_LT(largest_difference(tensions(simulation), {T.data(), static_cast<std::size_t>(T.size())}), 1e-8) << scene;
    EXPECT_TRUE(simulation.certify().passed()) << scene << ": " << simulation.certify().line();
  }
  EXPECT_GT(num_dependent, 50) << "ropes beyond the rank carry, too";
}

void append(const System& one, System* both) {
  const auto first = static_cast<Index>(both->masses.size());
  const auto move = [&](std::vector<Index> points) {
    for (Index& point : points) point += first;
    return points;
  };
  both->positions.insert(both->positions.end(), one.positions.begin(), one.positions.end());
  both->masses.insert(both->masses.end(), one.masses.begin(), one.masses.end());
  for (const auto& each : one.supports) both->supports.push_back({.points = move(each.points)});
  for (const Force& each : one.forces) {
    both->forces.push_back(each);
    std::get<ConstantForce>(both->forces.back()).points = move(std::get<ConstantForce>(each).points);
  }
  Ropes ropes = std::get<Ropes>(one.constraints[0]);
  ropes.name.clear();
  for (std::vector<Index>& path : ropes.paths) path = move(path);
  both->constraints.push_back(ropes);
}

/// Islands of masses 1e12 apart share their loads as they do alone.
TEST(DependentRopes, IslandsDecideAloneWhateverTheirMass) {
  std::mt19937 generator(9);
  for (int scene = 0; scene < 100; ++scene) {
    System both;
    std::vector<double> alone;
    for (const double scale : {1e-6, 1e6}) {
      const System one = make_many(generator, scale).system;
      append(one, &both);
      for (const double T : tensions(start(one))) alone.push_back(T / scale);
    }
    std::vector<double> together = tensions(start(both));
    const std::size_t light = std::get<Ropes>(both.constraints[0]).paths.size();
    for (std::size_t k = 0; k < together.size(); ++k) together[k] /= k < light ? 1e-6 : 1e6;
    EXPECT_LT(largest_difference(together, alone), 1e-8) << scene;
  }
}

/// A hub on five strings is thrown and comes to hang: tensions never push, whichever string is redundant.
TEST(DependentRopes, TensionsOfAHubNeverPush) {
  System system;
  for (int k = 0; k < 5; ++k) {
    system.positions.insert(system.positions.end(), {std::cos(1.2566 * k + 0.2), std::sin(1.2566 * k + 0.2), 0.1 * k});
    system.masses.push_back(1.0);
  }
  system.positions.insert(system.positions.end(), {0.0, 0.0, -1.0});
  system.masses.push_back(2.0);
  system.velocities.assign(18, 0.0);
  system.supports = {{.points = {0, 1, 2, 3, 4}}};
  system.constraints = {Ropes{.name = "strings", .paths = {{0, 5}, {1, 5}, {2, 5}, {3, 5}, {4, 5}}}};
  system.forces = {ConstantForce{.points = {5},
                                 .force = {ScalarFunction::formula("9*sin(3*t)"), ScalarFunction::formula("7*cos(2*t)"),
                                           ScalarFunction::formula("-5+6*sin(5*t)")}}};
  Simulation simulation = start(system);
  for (int k = 1; k <= 40; ++k) {
    const Outcome outcome = simulation.advance_to(0.1 * k);
    ASSERT_TRUE(outcome.ok()) << outcome.what;
    const std::vector<double> T = tensions(simulation);
    EXPECT_GT(*std::ranges::min_element(T), -1e-11) << k;
    EXPECT_TRUE(simulation.certify().passed()) << k << ": " << simulation.certify().line();
  }
  EXPECT_GT(simulation.report().contact_events.size(), 3u);
}

/// The liveliest one of ropes on a line decides what they give back, in any order.
TEST(DependentRopes, SeveralRestitutionsOnOneLineAreIndependentOfTheirOrder) {
  for (const std::vector<double>& parts : {std::vector{0.2, 0.7}, {0.7, 0.2}, {0.0, 0.7, 0.4}, {0.7, 0.4, 0.0}}) {
    System system;
    system.positions = {0, 0, 0, 1, 0, 0};
    system.velocities = {0, 0, 0, 3, 1, 0};
    system.masses = {1, 2};
    system.supports = {{.points = {0}}};
    for (const double e : parts) system.constraints.push_back(Ropes{.paths = {{0, 1}}, .restitution = e});
    Simulation simulation = start(system);
    ASSERT_TRUE(simulation.outcome().ok()) << simulation.outcome().what;
    EXPECT_NEAR(simulation.velocities()[3], -0.7 * 3.0, 1e-13);
    EXPECT_NEAR(simulation.velocities()[4], 1.0, 1e-13);
    ASSERT_EQ(simulation.report().contact_events.size(), 1u);
    const ContactEvent& event = simulation.report().contact_events[0];
    double impulse = 0.0;
    for (const double each : event.impulses) impulse += each;
    EXPECT_NEAR(impulse, 2.0 * 1.7 * 3.0, 1e-12);
    EXPECT_NEAR(event.energy_lost, 0.5 * 2.0 * 9.0 * (1.0 - 0.49), 1e-12);
  }
}

/// A point on three ropes in a plane, each with its own e: the velocity is that of the only complementary impulses.
TEST(DependentRopes, RandomImpactsWithSeveralRestitutionsFollowNoOrder) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> number(-1.0, 1.0), part(0.0, 1.0);
  for (int scene = 0; scene < 300; ++scene) {
    std::vector<double> angle(4), e(4);
    for (std::size_t k = 0; k < 4; ++k) {
      angle[k] = 1.2 * number(generator);
      e[k] = part(generator);
    }
    const double vx = 1.0 + part(generator), vy = 0.3 * number(generator);
    const auto velocity = [&](std::vector<std::size_t> order) {
      System system;
      system.positions = {0, 0, 0};
      system.velocities = {vx, vy, 0};
      system.masses = {1.5};
      for (const std::size_t k : order) {
        system.positions.insert(system.positions.end(), {-std::cos(angle[k]), -std::sin(angle[k]), 0});
        system.masses.push_back(1.0);
        system.supports.push_back({.points = {static_cast<Index>(system.masses.size()) - 1}});
        system.constraints.push_back(
            Ropes{.paths = {{0, static_cast<Index>(system.masses.size()) - 1}}, .restitution = e[k]});
      }
      system.velocities.resize(system.positions.size());
      const Simulation simulation = start(system);
      EXPECT_TRUE(simulation.outcome().ok()) << scene << ": " << simulation.outcome().what;
      return std::vector<double>(simulation.velocities().begin(), simulation.velocities().begin() + 3);
    };
    const std::vector<double> v = velocity({0, 1, 2, 3});
    EXPECT_LT(largest_difference(v, velocity({3, 1, 0, 2})), 1e-11) << scene;
    EXPECT_LT(largest_difference(v, velocity({2, 3, 1, 0})), 1e-11) << scene;
    const auto rate = [&](std::size_t k, double x, double y) {
      return x * std::cos(angle[k]) + y * std::sin(angle[k]);
    };
    bool all_approach = true;  // else others may follow, of what one drives shut
    for (std::size_t k = 0; k < 4; ++k) all_approach = all_approach && rate(k, vx, vy) > 0.0;
    for (std::size_t k = 0; k < 4; ++k)
      EXPECT_LT(rate(k, v[0], v[1]), all_approach ? -e[k] * rate(k, vx, vy) + 1e-11 : 1e-11) << scene;
    EXPECT_LE(v[0] * v[0] + v[1] * v[1], vx * vx + vy * vy + 1e-12) << scene;
  }
}

}  // namespace
}  // namespace tanor
