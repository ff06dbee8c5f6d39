#include <gtest/gtest.h>

#include <random>
#include <vector>

#include <tanor/user_kernel.hpp>

#include "evaluate/forces.hpp"
#include "system/numbering.hpp"

namespace tanor {
using namespace detail;
namespace {

System make_system() {
  System system;
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (int i = 0; i < 12; ++i) system.positions.push_back(uniform(random));
  system.masses = {1.0, 2.0, 3.0, 4.0};
  system.supports = {{"held", {3}, {}}};
  system.forces = {
      Springs{"damped", {{0, 1}, {2, 3}}, 7.0, 0.4, 0.2},
      Springs{"plain", {{1, 2}}, 5.0, 0.3, 0.0},
      Drag{"drag", {0, 2}, 0.5, 0.7},
      FormulaForce{"formula", {1, 2}, formula_force({"x*y - vz^2", "sin(z)*vx", "t*x"})},
      FormulaForce{"callable", {0}, make_force_kernel([](const auto& r, const auto& v, double t) {
                     using T = std::decay_t<decltype(r[0])>;
                     return std::array<T, 3>{r[1] * v[0] * t, r[0] * r[2], v[1] * v[1]};
                   })},
      FormulaForce{.name = "tuple",
                   .points = {},
                   .kernel = formula_tuple_force(
                       std::vector<std::string>{"x2*vy1", "t*y1^2", "vz2*z1", "-x2*vy1", "sin(x1)*z2", "vx1*vx2"}),
                   .tuples = {{0, 2}, {1, 3}, {2, 1}}},
      Potential{"energy", {{2, 0, 3}}, formula_potential("sin(x1*y2)*z3^2 + t*exp(z1*x2) + y1^2*x3*z2", 3), {}}};
  return system;
}

/// The derivatives are compared with central differences. For compliant springs with a given tau, only the turning of
/// the force counts.
TEST(ForceDerivativesTest, AgreeWithDifferencesOfTheForces) {
  const System system = make_system();
  const Numbering numbering = number(system);
  Forces forces(system, numbering);
  const Parallel serial(1);
  const double t = 0.8;
  std::vector<double> r(12), v(12);
  numbering.gather_points(system.positions, r);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  for (double& number : v) number = uniform(random);
  const std::vector<Spring> compliant = forces.springs().list_compliant();
  ASSERT_EQ(compliant.size(), 2u);
  const std::vector<double> tau{0.6, -0.9}, unit_mass(4, 1.0);
  const std::vector<Coupling> couplings = forces.list_couplings();
  std::vector<Block3> own_r(3), own_v(3), coupling_r(couplings.size()), coupling_v(couplings.size());
  std::vector<Block3> influence(forces.list_influences().size()), influence_v(influence.size());
  forces.evaluate_derivatives(
      serial, t, r.data(), v.data(), tau.data(),
      {own_r.data(), own_v.data(), coupling_r.data(), coupling_v.data(), influence.data(), influence_v.data()});
  const std::vector<Influence> influences = forces.list_influences();
  ASSERT_EQ(influences.size(), 12u);
  const auto derivative = [&](bool in_r, int i, int j, int a, int c) {
    double sum = i == j ? (in_r ? own_r : own_v)[i](a, c) : 0.0;
    for (std::size_t k = 0; k < couplings.size(); ++k) {
      const int sign =
          ((i == couplings[k].j) - (i == couplings[k].i)) * ((j == couplings[k].j) - (j == couplings[k].i));
      sum += sign * (in_r ? coupling_r : coupling_v)[k](a, c);
    }
    for (std::size_t k = 0; k < influences.size(); ++k) {
      if (influences[k].on == i && influences[k].of == j) sum += (in_r ? influence : influence_v)[k](a, c);
    }
    return sum;
  };
  const auto evaluate = [&] {
    std::vector<double> f(12), units(6), residuals(2);
    forces.evaluate(serial, t, r.data(), v.data(), f.data(), Forces::Which::WithoutCompliant);
    forces.springs().evaluate_compliant(serial, r.data(), v.data(), tau.data(), units.data(), residuals.data());
    forces.springs().add_compliant_forces(serial, units.data(), tau.data(), unit_mass.data(), f.data());
    return f;
  };
  const double e = 1e-5;
  for (const bool in_r : {true, false}) {
    for (int j = 0; j < 3; ++j) {
      for (int c = 0; c < 3; ++c) {
        double& x = (in_r ? r : v)[static_cast<std::size_t>(3 * j + c)];
        const double kept = x;
        x = kept + e;
        const std::vector<double> more = evaluate();
        x = kept - e;
        const std::vector<double> less = evaluate();
        x = kept;
        for (int i = 0; i < 3; ++i) {
          for (int a = 0; a < 3; ++a) {
            const auto at = static_cast<std::size_t>(3 * i + a);
            EXPECT_NEAR(derivative(in_r, i, j, a, c), (more[at] - less[at]) / (2.0 * e), 1e-8)
                << in_r << i << j << a << c;
          }
        }
      }
    }
  }
}

/// With tau = -k (L - rest) - c dL/dt the compliant springs have the forces of `evaluate`.
TEST(CompliantSpringsTest, HaveTheForcesOfTheWhole) {
  const System system = make_system();
  const Numbering numbering = number(system);
  Forces forces(system, numbering);
  const Parallel serial(1);
  std::vector<double> r(12), v(12, 0.3), whole(12), parts(12), units(6), tau(2, 0.0);
  numbering.gather_points(system.positions, r);
  v[4] = -0.8;
  forces.evaluate(serial, 0.0, r.data(), v.data(), whole.data());
  forces.evaluate(serial, 0.0, r.data(), v.data(), parts.data(), Forces::Which::WithoutCompliant);
  forces.springs().evaluate_compliant(serial, r.data(), v.data(), tau.data(), units.data(), tau.data());
  for (double& number : tau) number = -number;
  forces.springs().add_compliant_forces(serial, units.data(), tau.data(), std::vector<double>(4, 1.0).data(),
                                        parts.data());
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(parts[i], whole[i], 1e-13);
}

}  // namespace
}  // namespace tanor
