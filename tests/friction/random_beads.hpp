#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <random>
#include <tanor/tanor.hpp>

namespace tanor {

/// A row of beads at rest, joined by rods, with any positions, masses and forces; the test adds their guides.
class RandomBeads {
 public:
  struct Bead {
    Index index;
    Eigen::Vector3d r;          ///< m
    Eigen::Vector3d direction;  ///< of its guide, unit length
    double mu;
  };

  RandomBeads(unsigned seed, double least_mu, double largest_mu) : random_(seed), coefficient_(least_mu, largest_mu) {}

  System system;
  Rods rods{"rods", {}, {}, {}};

  Bead add() {
    const Eigen::Vector3d r = 1.5 * any(), direction = any().normalized(), force = 4.0 * any();
    const auto bead = static_cast<Index>(system.masses.size());
    system.positions.insert(system.positions.end(), {r(0), r(1), r(2)});
    system.masses.push_back(std::exp(log_mass_(random_)));
    system.forces.push_back(ConstantForce{"", {bead}, Vector3{force(0), force(1), force(2)}});
    if (bead > 0) rods.pairs.push_back({bead - 1, bead});
    return {bead, r, direction, coefficient_(random_)};
  }

  System finish() {
    system.velocities.assign(system.positions.size(), 0.0);
    system.constraints.push_back(rods);
    return system;
  }

 private:
  Eigen::Vector3d any() { return {normal_(random_), normal_(random_), normal_(random_)}; }

  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> log_mass_{-1.0, 1.0}, coefficient_;
};

inline Vector3 vector_of(const Eigen::Vector3d& a) {
  return {a(0), a(1), a(2)};
}

/// Returns the status of a start where so many motions obey the law.
inline Status status_of(std::size_t motions) {
  return motions == 0 ? Status::NoSolution : motions == 1 ? Status::Ok : Status::NotUnique;
}

}  // namespace tanor
