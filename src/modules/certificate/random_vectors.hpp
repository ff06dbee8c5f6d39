#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "dynamics/model.hpp"

namespace tanor::detail {

/// Random numbers and vectors that depend only on the seed, so that no identity holds by accident.
class RandomVectors {
 public:
  explicit RandomVectors(const Model& model) : model_(model) {}

  /// Returns a number in (-1, 1), by splitmix64 (G. L. Steele, D. Lea, C. H. Flood 2014).
  double number() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return 0x1p-63 * static_cast<double>(static_cast<std::int64_t>(z ^ (z >> 31)));
  }
  /// Returns a vector [3n] with 0 at supports.
  std::vector<double> points() {
    std::vector<double> u(3 * model_.num_points(), 0.0);
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) u[i] = number();
    return u;
  }
  /// Returns M^-1/2 z, in which all points count alike, whatever their masses.
  std::vector<double> points_by_M() {
    std::vector<double> u = points();
    for (std::size_t i = 0; i < 3 * model_.num_moving(); ++i) u[i] *= std::sqrt(model_.inverse_mass[i / 3]);
    return u;
  }

 private:
  const Model& model_;
  std::uint64_t state_ = 20261;
};

}  // namespace tanor::detail
