#include <algorithm>

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include "certificate/certified.hpp"

namespace tanor {
namespace {

/// Forces of energies stand trial too: told of another law than was solved, the certificate says no.
TEST(CertificateOfEnergies, TheirForcesComeOnceMoreFromTheDefinition) {
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

}  // namespace
}  // namespace tanor
