#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "embed/openmm/tanor_openmm.hpp"

/// \file Systems of OpenMM with constraints, in a field that keeps them together; nm, ps, u.
namespace tanor::embed {

struct Molecules {
  std::unique_ptr<OpenMM::System> system = std::make_unique<OpenMM::System>();
  std::vector<OpenMM::Vec3> positions;
  std::vector<std::array<int, 2>> pairs;

  int add_particle(double mass, const OpenMM::Vec3& at) {
    positions.push_back(at);
    return system->addParticle(mass);
  }
  double distance(int i, int j, const std::vector<OpenMM::Vec3>& at) const {
    const OpenMM::Vec3 d = at[static_cast<std::size_t>(j)] - at[static_cast<std::size_t>(i)];
    return std::sqrt(d.dot(d));
  }
  /// At the distance that the particles have.
  void add_constraint(int i, int j) {
    pairs.push_back({i, j});
    system->addConstraint(i, j, distance(i, j, positions));
  }
  /// A force that OpenMM itself evaluates; `energy` in x, y, z.
  void add_field(const std::string& energy) {
    auto* const field = new OpenMM::CustomExternalForce(energy);
    for (int i = 0; i < system->getNumParticles(); ++i) field->addParticle(i);
    system->addForce(field);
  }
  ExactConstraints& add_exact_constraints() {
    auto* const exact = new ExactConstraints;
    system->addForce(exact);
    return *exact;
  }
  /// Largest deviation of a distance at `at` from the one of the start, relative.
  double violation(const std::vector<OpenMM::Vec3>& at) const {
    double worst = 0.0;
    for (const auto& [i, j] : pairs)
      worst = std::max(worst, std::abs(distance(i, j, at) / distance(i, j, positions) - 1.0));
    return worst;
  }
};

/// A random walk of `count` rods of 0.15 nm.
inline Molecules make_chain(int count) {
  Molecules chain;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  OpenMM::Vec3 at;
  for (int i = 0; i <= count; ++i) {
    chain.add_particle(14.0, at);
    if (i > 0) chain.add_constraint(i - 1, i);
    const OpenMM::Vec3 d(normal(random), normal(random), normal(random));
    at += d * (0.15 / std::sqrt(d.dot(d)));
  }
  chain.add_field("0.5*(x^2 + y^2 + z^2)");
  return chain;
}

/// All ten distances of a methane; nine are independent.
inline Molecules make_methane() {
  Molecules methane;
  const double a = 0.109 / std::sqrt(3.0);
  methane.add_particle(12.011, {0, 0, 0});
  for (const OpenMM::Vec3& corner : {OpenMM::Vec3(a, a, a), {a, -a, -a}, {-a, a, -a}, {-a, -a, a}})
    methane.add_particle(1.008, corner);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < i; ++j) methane.add_constraint(j, i);
  methane.add_field("2*(x^2 + y^2 + z^2)");
  return methane;
}

/// Two triangles with an edge in common, five rods.
inline Molecules make_diamond() {
  Molecules diamond;
  const double a = 0.15;
  for (const OpenMM::Vec3& at :
       {OpenMM::Vec3(0, 0, 0), {a, 0, 0}, {a / 2, a * std::sqrt(3.0) / 2, 0}, {1.5 * a, a * std::sqrt(3.0) / 2, 0.05}})
    diamond.add_particle(12.0, at);
  for (const auto& [i, j] : {std::array{0, 1}, {0, 2}, {1, 2}, {1, 3}, {2, 3}}) diamond.add_constraint(i, j);
  diamond.add_field("2*(x^2 + y^2 + z^2)");
  return diamond;
}

}  // namespace tanor::embed
