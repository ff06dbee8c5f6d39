#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <tanor/inverse_dynamics.hpp>

#include "report/json_text.hpp"

namespace tanor::report {

/// The forces of a motion, sample by sample.
struct ForcesOfMotion {
  std::string scene, motion;  ///< names
  Units units{};
  Json groups{};  ///< of constraints
  std::size_t num_points = 0, num_equations = 0;
  bool by_coordinates = false;  ///< the motion was given as q(t)
  std::vector<double> times;
  std::vector<MotionForces> samples;  ///< one for each time
  double acceleration_scale = 0.0;    ///< m/s^2, the largest of w, eta/m and u/m in the motion

  /// Returns the sample for which `number`, a function of a MotionForces, is largest.
  template <class Number>
  std::size_t find_worst(const Number& number) const {
    std::size_t worst = 0;
    for (std::size_t k = 1; k < samples.size(); ++k) {
      if (number(samples[k]) > number(samples[worst])) worst = k;
    }
    return worst;
  }
};

inline constexpr const char* forces_name = "forces.json";

/// Writes `forces.json` into a folder, which is created. Arrays over time (samples x 3 points, samples x equations) are
/// written into it or, above `largest_inline` rows of points, into `forces_<key>.npy` beside it. Values that were not
/// found are null.
void write_forces(const std::filesystem::path& directory, const ForcesOfMotion& forces);

}  // namespace tanor::report
