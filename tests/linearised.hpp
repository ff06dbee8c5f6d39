#pragma once

/// \file A system inside the library at one instant, with its numbering, K as blocks, and K as a dense matrix.

#include <vector>

#include <Eigen/Dense>

#include "evaluate/constraints.hpp"
#include "random_systems.hpp"
#include "system/numbering.hpp"

namespace tanor {
using namespace detail;

/// All arrays are in the inner order.
struct Linearised {
  Numbering numbering;
  Constraints constraints;
  std::vector<Incidence> incidences;
  std::vector<double> inverse_masses;  ///< [point], 0 for supports
  std::vector<double> r, v;            ///< 3n
  std::vector<double> blocks;

  Linearised(const System& system, double t, const std::vector<double>& positions,
             const std::vector<double>& velocities)
      : numbering(number(system)),
        constraints(system, numbering),
        incidences(constraints.list_incidences()),
        inverse_masses(numbering.num_points(), 0.0),
        r(positions.size()),
        v(positions.size()),
        blocks(3 * constraints.num_blocks()) {
    for (std::size_t i = 0; i < numbering.num_moving; ++i) {
      inverse_masses[i] = 1.0 / system.masses[static_cast<std::size_t>(numbering.user_point[i])];
    }
    numbering.gather_points(positions, r);
    numbering.gather_points(velocities, v);
    constraints.set_time(t);
    constraints.choose_frames();
    constraints.evaluate_gradients(Parallel(1), r.data(), blocks.data());
  }
  explicit Linearised(const RandomSystem& random)
      : Linearised(random.system, random.t, random.positions, random.velocities) {}

  /// Returns K, 3n x d, with the rows of supports.
  Eigen::MatrixXd K() const {
    Eigen::MatrixXd result =
        Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(r.size()), static_cast<Eigen::Index>(constraints.num_rows()));
    for (const auto& [point, row, block, sign] : incidences) {
      result.block<3, 1>(3 * point, row) += sign * reference::point(blocks, block);
    }
    return result;
  }
  /// Returns the diagonal of M^-1, 3n, with 0 at supports.
  Eigen::VectorXd inverse_M() const {
    Eigen::VectorXd result(static_cast<Eigen::Index>(r.size()));
    for (Eigen::Index c = 0; c < result.size(); ++c) result[c] = inverse_masses[static_cast<std::size_t>(c / 3)];
    return result;
  }
  /// Returns K'M^-1K.
  Eigen::MatrixXd S() const {
    const Eigen::MatrixXd k = K();
    return k.transpose() * inverse_M().asDiagonal() * k;
  }
};

}  // namespace tanor
