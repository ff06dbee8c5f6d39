/// The tests compare virial, stress and forces of constraints with closed forms.

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

/// Rigid dumbbells in a field.
struct Dumbbells : Host {
  Dumbbells()
      : Host({1.0, 3.0, 2.0, 0.5}, {0.3, 0.1, 0.0, 1.1, 0.7, 0.0, 50.0, -20.0, 3.0, 50.0, -19.0, 3.5},
             {Rods{"rods", {{0, 1}, {3, 2}}, {}, {}}}) {
    v = {0.2, -0.4, 0.7, -0.3, 0.9, 0.1, 0.3, 0.3, -0.2, 1.0, -0.4, 0.2};
    set_forces = [](const std::vector<double>& x, std::vector<double>* forces) {
      for (std::size_t i = 0; i < 4; ++i) {
        const double p = x[3 * i], q = x[3 * i + 1], s = x[3 * i + 2];
        (*forces)[3 * i] = -p * (1.0 + 0.01 * p * p);
        (*forces)[3 * i + 1] = -2.0 * q + std::sin(p);
        (*forces)[3 * i + 2] = -3.0 * s * static_cast<double>(i + 1);
      }
    };
  }
  /// Returns the sums of m v^2 + r f over the points and over the molecules' centers of mass.
  std::array<double, 2> atomic_and_molecular() const {
    std::array<double, 2> sums{};
    for (std::size_t k = 0; k < 12; ++k) sums[0] += masses[k / 3] * v[k] * v[k] + r[k] * f[k];
    for (std::size_t first = 0; first < 4; first += 2) {
      const double m0 = masses[first], m1 = masses[first + 1], m = m0 + m1;
      for (std::size_t d = 0; d < 3; ++d) {
        const std::size_t a = 3 * first + d, b = a + 3;
        const double place = (m0 * r[a] + m1 * r[b]) / m, speed = (m0 * v[a] + m1 * v[b]) / m;
        sums[1] += m * speed * speed + place * (f[a] + f[b]);
      }
    }
    return sums;
  }
};

TEST(Virial, MakesAtomicAndMolecularPressureEqualAtEveryInstant) {
  Dumbbells host;
  host.start();
  double worst = 0.0, scale = 0.0;
  for (int k = 0; k < 1000; ++k) {
    ASSERT_TRUE(host.step(2e-3)) << host.outcome.what;

    const ConstraintReport report =
        host.constrainer.solve({.positions = host.r, .velocities = host.v, .forces = host.f});

    ASSERT_TRUE(report.outcome.ok());
    const auto [atomic, molecular] = host.atomic_and_molecular();
    const double constraints = report.virial[0] + report.virial[1] + report.virial[2];
    worst = std::max(worst, std::abs(atomic + constraints - molecular));
    scale = std::max(scale, std::abs(molecular));
  }
  EXPECT_LE(worst, 1e-13 * scale);
}

/// Multipliers of a step are those of its instant up to O(h).
TEST(Virial, AgreesBetweenAStepAndItsInstantToFirstOrder) {
  double differences[2];
  for (const int refined : {0, 1}) {
    const double h = refined == 0 ? 1e-3 : 1e-4;
    Dumbbells host;
    host.start();
    std::vector<double> at_start(2), of_step(2);
    ASSERT_TRUE(
        host.constrainer
            .solve({.positions = host.r, .velocities = host.v, .forces = host.f, .wanted = {.multipliers = at_start}})
            .outcome.ok());
    host.old = host.r;
    host.kick(0.5 * h);
    for (std::size_t k = 0; k < 12; ++k) host.r[k] += h * host.v[k];
    const ConstraintReport report = host.constrainer.constrain_positions({.step = h,
                                                                          .old_positions = host.old,
                                                                          .positions = host.r,
                                                                          .velocities = host.v,
                                                                          .wanted = {.multipliers = of_step}});
    ASSERT_TRUE(report.outcome.ok());
    differences[refined] = std::abs(of_step[0] - at_start[0]) / std::abs(at_start[0]);
  }
  EXPECT_LE(differences[0], 1e-2);
  EXPECT_NEAR(differences[1] / differences[0], 0.1, 0.03);
}

/// A dumbbell that spins about its center has the tension m v^2/(L/2) and the virial -L tension along itself, half of
/// it
/// at each point.
TEST(Virial, IsTheClosedFormOfASpinningDumbbell) {
  const double m = 2.0, length = 0.8, omega = 3.0, tension = m * omega * omega * length / 2.0;
  const std::vector<double> r{100.0, 0.0, 0.0, 100.0, length, 0.0}, f(6, 0.0);
  const std::vector<double> v{omega * length / 2.0, 0.0, 0.0, -omega * length / 2.0, 0.0, 0.0};
  Constrainer constrainer(std::vector{m, m}, {Rods{"rods", {{0, 1}}, {}, {}}}, r);
  std::vector<double> lambda(1), forces(6), stress(18), w(6);

  const ConstraintReport report =
      constrainer.solve({.positions = r,
                         .velocities = v,
                         .forces = f,
                         .accelerations = w,
                         .wanted = {.multipliers = lambda, .forces = forces, .stress = stress}});

  ASSERT_TRUE(report.outcome.ok());
  EXPECT_NEAR(lambda[0], -tension, 1e-14 * tension);
  EXPECT_NEAR(forces[1], tension, 1e-14 * tension);
  EXPECT_NEAR(forces[4], -tension, 1e-14 * tension);
  EXPECT_NEAR(w[1], tension / m, 1e-14 * tension);
  EXPECT_EQ(report.virial[0], 0.0);
  EXPECT_NEAR(report.virial[1], -tension * length, 1e-13 * tension);
  for (const std::size_t point : {0U, 1U}) {
    for (std::size_t k = 0; k < 9; ++k)
      EXPECT_NEAR(stress[9 * point + k], k == 4 ? -tension * length / 2.0 : 0.0, 1e-13 * tension);
  }
}

/// For any kind of constraint the virial is the sum of r (x) F, and the stress of the points adds up to it.
TEST(Virial, IsTheSumOverThePointsForEveryKind) {
  const std::vector<double> r{0.1, 0.2, 1.0, 1.1, 0.3, 1.4, 1.9, 0.1, 0.7, 2.5, 0.9, 0.8};
  std::vector<double> v{0.3, -0.2, 0.5, 0.1, 0.7, -0.4, 0.2, 0.2, 0.9, -0.6, 0.1, 0.3};
  const std::vector<double> f{1.0, 2.0, -3.0, 0.5, -1.0, 2.0, 3.0, 1.0, -1.0, 0.2, -2.0, 1.0};
  Constrainer constrainer(std::vector{1.0, 2.0, 0.5, 1.5},
                          {Rods{"rods", {{0, 1}, {2, 1}}, {}, {}}, Angles{"angles", {{1, 2, 3}}, {}},
                           Planes{"planes", {0}, Vector3{0.0, 0.0, 1.0}, 1.0}},
                          r);
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome.ok());
  std::vector<double> forces(12), stress(36);

  const ConstraintReport report =
      constrainer.solve({.positions = r, .velocities = v, .forces = f, .wanted = {.forces = forces, .stress = stress}});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  std::array<double, 9> by_points{}, by_stress{};
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < 9; ++k) {
      by_points[k] += r[3 * i + k / 3] * forces[3 * i + k % 3];
      by_stress[k] += stress[9 * i + k];
    }
  }
  for (std::size_t k = 0; k < 9; ++k) EXPECT_NEAR(by_points[k], by_stress[k], 1e-12);
  const std::array<std::size_t, 6> places{0, 4, 8, 1, 2, 5};
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(report.virial[k], by_points[places[k]], 1e-12);
}

}  // namespace
}  // namespace tanor::host
