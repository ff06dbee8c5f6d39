/// Fekete points are a problem of the IVP test set (Mazzia, Magherini, Release 2.4, part II-4). Points of mass 1 on the
/// unit sphere push each other apart with (p_i - p_j)/|p_i - p_j|^2, in a drag of 0.5 v.
///
/// On the sphere (p_i - p_j).p_i = |p_i - p_j|^2/2, so each of the others pushes with 1/2 along p_i. With xi = |p| - 1,
///
///   -|v|^2 = p'w = (N - 1)/2 + lambda      lambda = -(N - 1)/2 - |v|^2,     whatever the motion.

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "base/parallel.hpp"

namespace tanor::cases {
using namespace detail;
namespace {

/// Makes points at rest on the unit sphere.
System make_fekete(const std::vector<Vector3>& points) {
  System system;
  system.name = "fekete points";
  Spheres sphere{"sphere", {}, Vector3{0, 0, 0}, 1.0};
  Drag drag{"drag", {}, 0.5, 0.0};
  for (const Vector3& point : points) {
    const auto i = static_cast<Index>(system.masses.size());
    system.positions.insert(system.positions.end(), point.begin(), point.end());
    system.masses.push_back(1.0);
    sphere.points.push_back(i);
    drag.points.push_back(i);
  }
  system.constraints = {sphere};
  system.forces = {drag, PairForces{.name = "repulsion", .law = PairLaw::Log, .strength = 1.0}};
  return system;
}

/// Returns the point on the unit sphere at this longitude and latitude.
Vector3 on_sphere(double alpha, double beta) {
  return {std::cos(alpha) * std::cos(beta), std::sin(alpha) * std::cos(beta), std::sin(beta)};
}

/// Returns rings of 3, 7, 6 and 4 points.
std::vector<Vector3> start_of_the_test_set() {
  struct Ring {
    int count;
    double turn, latitude;
  };
  std::vector<Vector3> points;
  for (const auto& [count, turn, latitude] : {Ring{3, M_PI / 13, 3 * M_PI / 8}, Ring{7, M_PI / 29, M_PI / 8},
                                              Ring{6, M_PI / 7, -2 * M_PI / 15}, Ring{4, M_PI / 17, -3 * M_PI / 10}}) {
    for (int i = 1; i <= count; ++i) points.push_back(on_sphere(2 * M_PI * i / count + turn, latitude));
  }
  return points;
}

/// Returns points on a spiral, moved away from their even spacing.
std::vector<Vector3> spiral(int count) {
  std::vector<Vector3> points;
  for (int i = 0; i < count; ++i) {
    const double height = 1.0 - (2.0 * i + 1.0) / count;
    points.push_back(on_sphere(M_PI * (3.0 - std::sqrt(5.0)) * i, std::asin(height) + 0.01 * std::sin(0.7 * i)));
  }
  return points;
}

struct Multipliers {
  double error = 0.0;           // largest |lambda + (N - 1)/2 + |v|^2|, relative
  double fastest_speed2 = 0.0;  // |v|^2
};

/// Runs the system and compares the multipliers at the output times.
Multipliers run(const System& system, const MotionOptions& motion, const std::vector<double>& times) {
  Simulation simulation(system, motion);
  const double others = static_cast<double>(system.num_points()) - 1.0;
  Multipliers result;
  const auto compare = [&] {
    const auto v = simulation.velocities();
    for (std::size_t i = 0; i < system.num_points(); ++i) {
      const double speed2 = v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1] + v[3 * i + 2] * v[3 * i + 2];
      const double expected = -0.5 * others - speed2;
      result.error = larger(result.error, std::abs(simulation.multipliers()[i] / expected - 1.0));
      result.fastest_speed2 = std::max(result.fastest_speed2, speed2);
    }
  };
  compare();
  for (const double t : times) {
    const Outcome outcome = simulation.advance_to(t);
    EXPECT_TRUE(outcome.ok()) << outcome.what;
    compare();
  }
  return result;
}

TEST(FeketeTest, MultipliersOf20PointsAreTheClosedFormAtEveryTime) {
  const MotionOptions motion{.method = Method::Dopri5, .rtol = 1e-8, .atol = 1e-10};
  std::vector<double> times;
  for (int k = 1; k <= 50; ++k) times.push_back(0.2 * k);

  const Multipliers found = run(make_fekete(start_of_the_test_set()), motion, times);

  EXPECT_LT(found.error, 1e-11);
  EXPECT_GT(found.fastest_speed2, 0.01) << "points that rest prove nothing about |v|^2";
}

TEST(FeketeTest, MultipliersOf2000PointsAreTheClosedFormAtEveryTime) {
  const MotionOptions motion{.method = Method::Dopri5, .rtol = 1e-6, .atol = 1e-8};

  const Multipliers found = run(make_fekete(spiral(2000)), motion, {0.01, 0.02, 0.05, 0.1});

  EXPECT_LT(found.error, 1e-11);
  EXPECT_GT(found.fastest_speed2, 0.01) << "points that rest prove nothing about |v|^2";
}

/// The points come to rest where the product of their distances is largest. For 20 of them the smallest known -sum ln
/// |p_i - p_j| over pairs is -54.011130 (Womersley's and Sloane's tables).
TEST(FeketeTest, TwentyPointsComeToRestWhereTheyAreFarthestApart) {
  Simulation simulation(make_fekete(start_of_the_test_set()), {.method = Method::Dopri5, .rtol = 1e-6, .atol = 1e-8});

  ASSERT_TRUE(simulation.advance_to(200.0).ok());

  EXPECT_NEAR(simulation.report().energy.now, -54.011130, 1e-5);
  EXPECT_LT(std::abs(simulation.report().energy.drift_relative()), 1e-4);
}

}  // namespace
}  // namespace tanor::cases
