#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

#include "reference.hpp"

/// \file Points of next to no mass: pulleys and joints that only pass forces on. M^-1/2 K then has rows of very
/// different sizes, and its columns look dependent though those of K are not.
namespace tanor {
namespace {

/// Solves at the start and returns the accelerations, and the multipliers in `lambda`.
std::vector<double> solve(const System& system, std::vector<double>* lambda) {
  Dynamics dynamics(system);
  std::vector<double> w(system.positions.size());
  lambda->resize(dynamics.num_equations());
  const SolveReport report =
      dynamics.solve({.time = 0.0, .positions = system.positions, .velocities = system.velocities},
                     {.accelerations = w, .multipliers = *lambda});
  EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
  return w;
}

TEST(Massless, APulleyHangsTwoWeightsFromAThird) {
  // 4 kg hold a pulley over which 1 kg and 2 kg hang: 4 a = -g (4 - 2 T/g), T = 15.696 N in the lower rope.
  for (const double mass : {1e-12, 1e-22, 1e-26, 1e-30, 1e-60, 1e-100}) {
    System system;
    system.positions = {0.0, 0.0, -1.0, 1.0, 0.0, -1.0, 0.8, 0.0, -2.0, 1.2, 0.0, -2.0};
    system.velocities.assign(12, 0.0);
    system.masses = {4.0, mass, 1.0, 2.0};
    const Vector3 up{0.0, 0.0, 1.0}, twice_down{0.0, 0.0, -2.0};
    system.constraints = {Linears{"big", {{0, 1}}, {up, up}, {}},
                          Linears{"small", {{1, 2, 3}}, {twice_down, up, up}, {}}};
    system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
    std::vector<double> lambda;
    const std::vector<double> w = solve(system, &lambda);
    const double expected[] = {-1.962, 1.962, 5.886, -1.962};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(w[3 * i + 2], expected[i], 1e-11) << mass << " kg, point " << i;
    Simulation simulation(system);
    const Outcome outcome = simulation.advance_to(0.5);
    EXPECT_TRUE(outcome.ok()) << mass << " kg: " << outcome.what;
    for (std::size_t i = 0; i < 4; ++i) {
      const double place = system.positions[3 * i + 2] + 0.125 * expected[i];
      EXPECT_NEAR(simulation.positions()[3 * i + 2], place, 1e-11) << mass << " kg, point " << i;
    }
  }
}

/// Makes a chain of rods in space, hung at one end, whose middle points have masses of all sizes.
System make_chain(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(-1.0, 1.0), log_mass(-30.0, 30.0);
  std::uniform_int_distribution<std::size_t> length(3, 12);
  const std::size_t count = length(random);
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (std::size_t i = 0; i < count; ++i) {
    for (int c = 0; c < 3; ++c) {
      system.positions.push_back(place(random));
      system.velocities.push_back(0.0);
    }
    // No two points without mass follow each other, since their directions would be free.
    const bool is_odd = i % 2 == 1 && i + 1 < count;
    system.masses.push_back(is_odd ? std::pow(10.0, log_mass(random)) : 1.0 + 0.5 * place(random));
    if (i > 0) rods.pairs.push_back({static_cast<Index>(i) - 1, static_cast<Index>(i)});
  }
  system.constraints = {rods, Spheres{"hook", {0}, Vector3{2.0, 0.0, 0.0}, {}}};
  system.forces = {Gravity{"", {0.0, -9.81, 0.0}}};
  return system;
}

/// Makes a tower of pulleys of next to no mass: over each hang a weight and the next pulley, over the last two weights.
System make_tower(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> log_mass(-30.0, -10.0), weight(0.5, 3.0);
  const std::size_t levels = 1 + seed % 6;
  System system;
  const auto add = [&](double mass) {
    system.masses.push_back(mass);
    const double z = -static_cast<double>(system.masses.size());
    system.positions.insert(system.positions.end(), {0.1 * z, 0.0, z});
    return static_cast<Index>(system.masses.size() - 1);
  };
  const Vector3 up{0.0, 0.0, 1.0}, twice_down{0.0, 0.0, -2.0};
  const Index top = add(weight(random));
  Index pulley = add(std::pow(10.0, log_mass(random)));
  system.constraints.push_back(Linears{"top", {{top, pulley}}, {up, up}, {}});
  for (std::size_t k = 0; k < levels; ++k) {
    const Index left = add(weight(random));
    const Index right = add(k + 1 < levels ? std::pow(10.0, log_mass(random)) : weight(random));
    system.constraints.push_back(
        Linears{"rope" + std::to_string(k), {{pulley, left, right}}, {twice_down, up, up}, {}});
    pulley = right;
  }
  system.velocities.assign(system.positions.size(), 0.0);
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}};
  return system;
}

/// Returns the largest defects of K'w + phi = 0, of M w = f + K lambda over the forces, and of w_i = f_i/m_i across the
/// gradients at point i, where nothing holds it. Together they say that w is the solution, whatever the masses are.
std::array<double, 3> measure(const System& system, const std::vector<double>& w, const std::vector<double>& lambda) {
  const reference::Mechanics dense = reference::make_mechanics(system, 0.0, system.positions, system.velocities);
  const Eigen::VectorXd a = reference::vector(w), reactions = dense.K * reference::vector(lambda);
  const double size = a.cwiseAbs().maxCoeff();
  std::array<double, 3> defects{(dense.K.transpose() * a + dense.phi).cwiseAbs().maxCoeff() / size, 0.0, 0.0};
  for (Eigen::Index i = 0; i < a.size(); i += 3) {
    const Eigen::Vector3d inertia = dense.M.segment<3>(i).cwiseProduct(a.segment<3>(i)), force = dense.f.segment<3>(i);
    const double largest = inertia.norm() + force.norm() +
                           (dense.K.middleRows<3>(i).cwiseAbs() * reference::vector(lambda).cwiseAbs()).norm();
    defects[1] = std::max(defects[1], (inertia - force - reactions.segment<3>(i)).norm() / largest);
    const Eigen::Matrix3Xd gradients = dense.K.middleRows<3>(i);
    const Eigen::FullPivLU<Eigen::MatrixXd> across(gradients.transpose());
    const Eigen::MatrixXd free = across.kernel();
    if (across.dimensionOfKernel() == 0) continue;
    const Eigen::Vector3d rest = a.segment<3>(i) - force.cwiseQuotient(dense.M.segment<3>(i));
    defects[2] = std::max(defects[2], (free.colwise().normalized().transpose() * rest).norm() / (9.81 + size));
  }
  return defects;
}

void expect_solutions(System (*make)(unsigned)) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    const System system = make(seed);
    std::vector<double> lambda;
    const std::vector<double> w = solve(system, &lambda);
    for (const double defect : measure(system, w, lambda)) EXPECT_LE(defect, 1e-8) << "seed " << seed;
  }
}

TEST(Massless, ChainsWithMassesOfAllSizesFallAsTheEquationsSay) {
  expect_solutions(make_chain);
}

TEST(Massless, TowersOfPulleysFallAsTheEquationsSay) {
  expect_solutions(make_tower);
}

}  // namespace
}  // namespace tanor
