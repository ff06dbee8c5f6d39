/// Newton's matrix of the implicit methods has the derivatives of energies and formulas of tuples, so that steps far
/// beyond those of explicit methods converge, and end where dop853 does.

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/equilibrium.hpp>
#include <tanor/motion.hpp>

#include "scenes.hpp"

namespace tanor {
namespace {

constexpr int count = 7;
constexpr double t_end = 1.0;

/// Makes the mass points of a clamped zigzag that turns, which stiff energies alone hold together.
System make_beam() {
  System beam;
  for (int i = 0; i < count; ++i)
    scenes::add_point({0.09 * i, 0.03 * std::cos(0.8 * i), 0.03 * std::sin(0.8 * i)}, &beam);
  beam.supports = {{"clamp", {0, 1, 2}, {}}};
  return beam;
}

double distance(const System& system, std::size_t i, std::size_t j) {
  const Vector3 a = scenes::place_of(system, i), b = scenes::place_of(system, j);
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

System make_beam_of_energies() {
  System beam = make_beam();
  Bonds bonds{.name = "bonds"};
  Bendings bendings{.name = "bendings"};
  Torsions torsions{.name = "torsions", .law = TorsionLaw::Periodic};
  for (Index i = 0; i < count; ++i) {
    if (i > 2) bonds.pairs.push_back({i - 1, i});
    if (i > 2) bendings.triples.push_back({i - 2, i - 1, i});
    if (i > 2) torsions.quadruples.push_back({i - 3, i - 2, i - 1, i});
  }
  bonds.stiffness = 1e6;
  bonds.rest_length = distance(beam, 0, 1);
  bendings.stiffness = 2e3;
  bendings.rest = 2.7;
  torsions.stiffness = 50.0;
  torsions.phase = 0.4;
  beam.forces = {bonds, bendings, torsions};
  return beam;
}

/// Makes the beam of springs from each point to the three before it, as texts.
System make_beam_of_formulas() {
  System beam = make_beam();
  for (int reach = 1; reach <= 3; ++reach) {
    const std::string length = std::to_string(distance(beam, 0, static_cast<std::size_t>(reach)));
    const std::string pull = "1e6*(1 - " + length + "/sqrt((x2-x1)^2 + (y2-y1)^2 + (z2-z1)^2))";
    std::vector<std::string> texts;
    for (const char* along : {"(x2-x1)", "(y2-y1)", "(z2-z1)"}) texts.push_back(pull + "*" + along);
    for (int axis = 0; axis < 3; ++axis) texts.push_back("-" + texts[static_cast<std::size_t>(axis)]);
    FormulaForce springs{.name = "springs" + std::to_string(reach), .kernel = formula_tuple_force(texts)};
    for (Index i = 3; i < count; ++i) springs.tuples.push_back({i - reach, i});
    beam.forces.push_back(springs);
  }
  return beam;
}

/// Puts the beam at rest and pulls it by a load that grows slowly, so that fast vibrations sleep.
System make_loaded(System beam) {
  const EquilibriumResult rest = find_equilibrium(beam, {.accept = AcceptedEquilibria::Any});
  EXPECT_TRUE(rest.outcome.ok()) << rest.outcome.what;
  beam.positions = rest.positions;
  beam.velocities.assign(beam.positions.size(), 0.0);
  beam.forces.push_back(Potential{
      .name = "load", .points = {{count - 1}}, .kernel = formula_potential("-(1-cos(3*t))^2*(z1+0.5*y1)", 1)});
  return beam;
}

class StiffEnergies : public testing::TestWithParam<bool> {
 protected:
  System make() const { return make_loaded(GetParam() ? make_beam_of_formulas() : make_beam_of_energies()); }
};
INSTANTIATE_TEST_SUITE_P(Beams, StiffEnergies, testing::Bool(),
                         [](const auto& at) { return std::string(at.param ? "OfFormulas" : "OfEnergies"); });

TEST_P(StiffEnergies, AreSteppedImplicitlyToWhereDop853Ends) {
  const System system = make();
  Simulation exact(system, {.method = Method::Dop853, .rtol = 1e-10, .atol = 1e-13});
  ASSERT_TRUE(exact.advance_to(t_end).ok()) << exact.outcome().what;
  Simulation radau(system, {.method = Method::Radau5, .rtol = 1e-5, .atol = 1e-8});
  Simulation alpha(system, {.method = Method::GeneralizedAlpha, .step = 0.004});

  ASSERT_TRUE(radau.advance_to(t_end).ok()) << radau.outcome().what;
  ASSERT_TRUE(alpha.advance_to(t_end).ok()) << alpha.outcome().what;

  const double moved = largest_difference(exact.positions(), system.positions);
  ASSERT_GT(moved, 1e-5);
  EXPECT_LT(largest_difference(radau.positions(), exact.positions()), 2e-2 * moved);
  EXPECT_LT(largest_difference(alpha.positions(), exact.positions()), 2e-2 * moved);
  // Without the derivatives Newton's iteration converges only for steps as short as those of explicit methods.
  EXPECT_LT(5 * radau.report().steps, exact.report().steps);
  EXPECT_LT(radau.report().counters.evaluations, 20 * radau.report().steps + 100);
}

}  // namespace
}  // namespace tanor
