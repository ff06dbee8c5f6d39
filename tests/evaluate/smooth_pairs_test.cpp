/// The tests compare pair forces of the laws that have a definition over a scalar type with that definition.

#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "evaluate/evaluated_pairs.hpp"
#include "evaluate/forces.hpp"

namespace tanor {
using namespace detail;
namespace {

/// For few points and laws with a definition over a scalar type, the sums by hand are those of the single pairs.
TEST(SmoothPairTest, ForcesByHandAreThoseOfTheDefinition) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  System system;
  std::vector<double> charges;
  for (int i = 0; i < 12; ++i) {
    for (int axis = 0; axis < 3; ++axis) system.positions.push_back(uniform(random));
    charges.push_back(uniform(random));
  }
  system.masses.assign(12, 1.0);
  system.supports = {Support{"", {3, 8}}};
  system.constraints = {Rods{"rods", {{0, 1}, {1, 2}}}};
  const PairForces laws[] = {
      {.law = PairLaw::Coulomb, .strength = -2.0, .exclude_rods = true, .charges = charges},
      {.points = {5, 2, 8, 3, 1}, .law = PairLaw::Coulomb, .strength = 1.5, .charges = {1.0, 2.0, 3.0, 4.0, 5.0}},
      {.law = PairLaw::Yukawa, .strength = 0.7, .length = 0.6},
      {.law = PairLaw::Morse, .depth = 0.4, .width = 1.3, .rest_length = 0.8}};
  for (const PairForces& pairs : laws) {
    system.forces = {pairs};
    const Numbering numbering = detail::number(system);
    PairField field(system, pairs, numbering);
    const PotentialFamily family(make_pair_energies(system, pairs), numbering);
    std::vector<double> r(36), f(36, 0.0), by_pair(6 * family.size()), rates(family.size()), energies(family.size()),
        wanted(36, 0.0);
    numbering.gather_points(system.positions, r);
    field.add_forces(Parallel(1), r.data(), f.data());
    family.evaluate_forces(Parallel(1), 0.0, r.data(), by_pair.data(), rates.data());
    family.evaluate_energies(Parallel(1), 0.0, r.data(), energies.data());
    double energy = 0.0, largest = 0.0;
    for (std::size_t k = 0; k < family.size(); ++k) {
      energy += energies[k];
      for (std::size_t i = 0; i < 2; ++i)
        add_to(wanted.data(), family.point(k, i), load(by_pair.data(), i * family.size() + k));
    }
    for (const double x : wanted) largest = std::max(largest, std::abs(x));
    EXPECT_NEAR(field.potential(Parallel(1), r.data()), energy, 1e-13 * (std::abs(energy) + 1.0));
    for (std::size_t i = 0; i < 36; ++i)
      EXPECT_NEAR(f[i], wanted[i], 1e-13 * largest) << static_cast<int>(pairs.law) << i;
  }
}

/// The law is cut and shifted in a periodic box, where the force is that of the nearest images within the cutoff.
TEST(SmoothPairTest, ACutoffShiftsTheEnergy) {
  for (const PairForces& pairs :
       {PairForces{.law = PairLaw::Yukawa, .cutoff = 1.5, .strength = 2.0, .box = {4, 4, 4}, .length = 0.5},
        PairForces{
            .law = PairLaw::Morse, .cutoff = 1.5, .box = {4, 4, 4}, .depth = 1.2, .width = 2.0, .rest_length = 1.0}}) {
    const System system = make_two_points(pairs, 3.2);  // the distance to the image is 0.8
    const Numbering numbering = detail::number(system);
    PairField field(system, pairs, numbering);
    std::vector<double> r(6), f(6, 0.0);
    numbering.gather_points(system.positions, r);
    field.add_forces(Parallel(1), r.data(), f.data());
    const auto u = [&](double x) { return KindOf<PairForces>::smooth_energy(pairs, x, 1.0); };
    const double e = 1e-6, force = -(u(0.8 + e) - u(0.8 - e)) / (2.0 * e);
    EXPECT_NEAR(field.potential(Parallel(1), r.data()), u(0.8) - u(1.5), 1e-14);
    EXPECT_NEAR(std::abs(f[0]) + std::abs(f[1]) + std::abs(f[2]), std::abs(force), 1e-8);
  }
}

}  // namespace
}  // namespace tanor
