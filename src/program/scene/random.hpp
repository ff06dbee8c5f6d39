#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include <tanor/time_function.hpp>

namespace tanor::scene {

/// Random numbers that depend on the seed only and not on the machine. They use the engine of the C++ standard, but not
/// its distributions, which differ between standard libraries.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// Returns a number uniform on (0, 1), with 53 bits.
  double uniform() { return (static_cast<double>(engine_() >> 11) + 0.5) * 0x1p-53; }

  /// Returns a number uniform on 0 … count - 1.
  std::int64_t below(std::int64_t count) { return static_cast<std::int64_t>(uniform() * static_cast<double>(count)); }

  /// Returns a normal number with mean 0 and variance 1 by the ratio of uniforms (Kinderman and Monahan 1977). The
  /// value contains no logarithm, so it does not depend on the mathematical library.
  double normal() {
    while (true) {
      const double u = uniform(), x = 1.7155277699214135 * (uniform() - 0.5) / u;  // sqrt(8/e)
      if (x * x <= -4.0 * std::log(u)) return x;
    }
  }

  /// Returns a point uniform on the unit sphere, by rejection from the cube.
  Vector3 direction() {
    while (true) {
      const double x = 2.0 * uniform() - 1.0, y = 2.0 * uniform() - 1.0, z = 2.0 * uniform() - 1.0;
      const double square = x * x + y * y + z * z;
      if (square > 1.0 || square < 1e-4) continue;
      const double scale = 1.0 / std::sqrt(square);
      return {scale * x, scale * y, scale * z};
    }
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace tanor::scene
