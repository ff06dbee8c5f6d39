#pragma once

/// \file Distances of an answer from a reference.

#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "cases/interfaces.hpp"
#include "cases/scenes.hpp"
#include "measures.hpp"

namespace tanor::cases {

/// Errors of r, v, w, K lambda and lambda, each relative to the largest value that it takes in its case.
class ReferenceMotion {
 public:
  explicit ReferenceMotion(const CaseScene& scene) : scene_(scene), trajectory_(read_trajectory(scene.reference)) {
    for (const Instant& instant : trajectory_) {
      const Quantities wanted = read(instant);
      for (std::size_t k = 0; k < wanted.size(); ++k) scale_[k] = std::max(scale_[k], largest(wanted[k]));
    }
  }

  const Instant& start() const { return trajectory_.front(); }
  /// Returns the instants after the start.
  std::span<const Instant> instants() const { return std::span(trajectory_).subspan(1); }

  /// Returns the worst of the five relative errors on the masses.
  double error(const Answer& answer, const Instant& instant) const {
    const auto masses = [&](std::span<const double> all) { return all.subspan(3 * scene_.num_supports); };
    const std::span<const double> found[]{masses(answer.positions), masses(answer.velocities),
                                          masses(answer.accelerations), masses(answer.reactions), answer.multipliers};
    const Quantities wanted = read(instant);
    double result = 0.0;
    for (std::size_t k = 0; k < wanted.size(); ++k) {
      result = std::max(result, largest_difference(found[k], wanted[k]) / scale_[k]);
    }
    return result;
  }

 private:
  using Quantities = std::array<std::vector<double>, 5>;
  Quantities read(const Instant& instant) const {
    return {instant.r, instant.v, instant.w, scene_.reactions(instant), scene_.multipliers(instant)};
  }

  const CaseScene& scene_;
  std::vector<Instant> trajectory_;
  std::array<double, 5> scale_{};
};

/// Expects -lambda = T_i and w = 0 as in case 06.
inline void expect_rest_with_tensions(std::span<const double> accelerations, std::span<const double> multipliers) {
  const std::vector<double> tensions = numbers(read_case("06_catenary_N10").at("tensions"));
  ASSERT_EQ(multipliers.size(), tensions.size());
  for (std::size_t k = 0; k < tensions.size(); ++k) {
    EXPECT_NEAR(-multipliers[k], tensions[k], 1e-12 * tensions[k]) << "rod " << k;
  }
  EXPECT_LT(largest(accelerations), 1e-12 * 9.81);
}

}  // namespace tanor::cases
