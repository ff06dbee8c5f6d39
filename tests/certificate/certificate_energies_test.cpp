#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include "certificate/certified.hpp"

namespace tanor {
namespace {

/// Forces of energies are checked too. A certificate that gets another law than the one solved fails.
TEST(CertificateOfEnergies, ComputesForcesOnceMoreFromTheDefinition) {
  System system;
  system.positions = {0, 0, 0, 1, 0.1, 0, 1.8, 0.9, 0.2, 2.9, 1.0, 0.6};
  system.velocities.assign(12, 0.0);
  system.masses = {1, 2, 1, 3};
  system.constraints = {Rods{"rod", {{0, 1}}}};
  system.forces = {Bonds{"fene", {{1, 2}, {2, 3}}, BondLaw::Fene, 3.0, {}, 2.0, {}, {}},
                   Bendings{"bend", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::Harmonic, 2.0, 2.0},
                   Torsions{"turn", {{0, 1, 2, 3}}, TorsionLaw::Opls, {1, 2, 3, 4}, {}, 1, {}, {}},
                   Potential{"own", {{0, 3}}, formula_potential("sin(x1 - 2*y2)*z2", 2), {}}};
  Case solved(system);
  const Certificate certificate = solved.certify();
  EXPECT_TRUE(certificate.passed()) << certificate.line();
  EXPECT_TRUE(std::ranges::any_of(certificate.checks,
                                  [](const CertificateCheck& check) { return check.identity == "f = -dU/dr"; }));
  for (std::size_t g = 0; g < system.forces.size(); ++g) {
    Case other(system);
    Force& force = other.told_system().forces[g];
    if (auto* const bonds = std::get_if<Bonds>(&force)) bonds->stiffness = 3.0001;
    if (auto* const bendings = std::get_if<Bendings>(&force)) bendings->rest = 2.0001;
    if (auto* const torsions = std::get_if<Torsions>(&force)) torsions->coefficients[3] = 4.001;
    if (auto* const own = std::get_if<Potential>(&force)) own->kernel = formula_potential("sin(x1 - 2.001*y2)*z2", 2);
    EXPECT_FALSE(other.certify().passed()) << g;
  }
}

/// Makes three links in a plane, each turned by `bend` against the one before it.
System bent_chain(double bend) {
  System system;
  double angle = 0.3, x = 0.0, y = 0.0;
  for (int i = 0; i < 4; ++i) {
    system.positions.insert(system.positions.end(), {x, y, 0.1 * x});
    x += 0.1 * std::cos(angle);
    y += 0.1 * std::sin(angle);
    angle += bend;
  }
  system.masses.assign(4, 0.1);
  return system;
}

/// The law is smooth there, since the force is (cos theta - cos theta0) times a gradient, and both of them vanish.
TEST(CertificateOfEnergies, StraightChainsOfLawCosineHarmonicPass) {
  for (const double bend : {0.0, 1e-10, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3}) {
    System system = bent_chain(bend);
    system.constraints = {Rods{"rods", {{0, 1}, {1, 2}, {2, 3}}}};
    system.forces = {Bendings{"bend", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::CosineHarmonic, 1.0, M_PI}};

    const Certificate certificate = Case(system).certify();

    EXPECT_TRUE(certificate.passed()) << bend << " " << certificate.line();
  }
}

/// The allowance for rounding is small beside the force. A wrong stiffness shows where the force is 1e-7 of its own
/// terms.
TEST(CertificateOfEnergies, NearlyStraightChainsOfAnotherStiffnessFail) {
  System system = bent_chain(1e-4);
  system.forces = {Bendings{"bend", {{0, 1, 2}, {1, 2, 3}}, BendingLaw::CosineHarmonic, 1.0, M_PI}};
  Case other(system);
  std::get<Bendings>(other.told_system().forces[0]).stiffness = 1.0001;

  EXPECT_FALSE(other.certify().passed());
}

/// Laws that end at a straight or folded angle lose digits near it, since the relative error of the direction is
/// 1e-16/sine.
TEST(CertificateOfEnergies, NearlyUndefinedDirectionsPass) {
  for (const double sine : {1.1e-8, 2e-8, 1e-7, 1e-6, 1e-5, 1e-4}) {
    System torsion;
    torsion.positions = {0.4, 0.04 + sine, 0.12, 0, 0, 0, -1.2, -0.12, -0.36, -1.6, -0.16, -0.48 + sine};
    torsion.masses = {1, 2, 1, 3};
    torsion.forces = {Torsions{"turn", {{0, 1, 2, 3}}, TorsionLaw::Opls, {1.1, -0.3, 2.2, 0.7}, {}, 1, {}, {}}};
    System folded;
    folded.positions = {1.0, sine, 0.3, 0, 0, 0, 0.7, -sine, 0.21};
    folded.masses = {1, 2, 3};
    folded.forces = {Bendings{"bend", {{0, 1, 2}}, BendingLaw::Harmonic, 2.0, 2.0}};
    for (const System& system : {torsion, folded}) {
      const Certificate certificate = Case(system).certify();
      EXPECT_TRUE(certificate.passed()) << sine << " " << certificate.line();
    }
  }
}

}  // namespace
}  // namespace tanor
