#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "dynamics/model.hpp"

namespace tanor {

/// Random numbers and vectors, independent of everything but the seed: no identity may hold by chance.
class RandomVectors {
 public:
  explicit RandomVectors(const Model& model) : model_(model) {}

  /// In (-1, 1), by splitmix64 (G. L. Steele, D. Lea, C. H. Flood 2014).
  double number() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return 0x1p-63 * static_cast<double>(static_cast<std::int64_t>(z ^ (z >> 31)));
  }
  /// [3n]; supports: 0.
  std::vector<double> points() {
    std::vector<double> u(3 * model_.num_points(), 0.0);
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) u[i] = number();
    return u;
  }
  /// M^-1/2 z: no point counts more than others, whatever their masses.
  std::vector<double> points_by_M() {
    std::vector<double> u = points();
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) u[i] *= std::sqrt(model_.inverse_mass[i / 3]);
    return u;
  }

 private:
  const Model& model_;
  std::uint64_t state_ = 20261;
};

}  // namespace tanor
