#pragma once

#include <Eigen/Dense>
#include <limits>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/vec3.hpp"
#include "friction/contact_problem.hpp"

namespace tanor {

/// Contacts of one island that obey Coulomb's law, and what they choose: the modes of those at rest.
struct ContactChoice {
  std::size_t island = 0;
  std::vector<std::size_t> members;  ///< contacts
  std::vector<Vec3> directions;      ///< of the components
  ContactProblem problem;
  Eigen::MatrixXd P;  ///< [3 contacts][k], P0 [3 contacts]: accelerations of the points, P0 + P x, m/s^2
  Eigen::VectorXd P0;
  double acceleration_scale = 1.0;  ///< m/s^2, of what cancels in the accelerations around them
  Eigen::VectorXd before;           ///< friction before, where there was some
  ContactSolutions solutions;
  Eigen::VectorXd x;  ///< the one taken; empty: none

  std::vector<char> sticks;  ///< [member] by x
  Eigen::VectorXd share;     ///< x with the share of those that stick that has most to spare
  Eigen::VectorXd weights;   ///< [member] of its changes
  double load = std::numeric_limits<double>::quiet_NaN();  ///< the largest of its loads; NaN: there is one share only
  bool has_shared = false;                                 ///< modes and shares are those of x

  std::size_t size() const { return members.size(); }
  /// Acceleration of the point of a member, m/s^2.
  Vec3 acceleration(std::size_t member, const Eigen::VectorXd& at) const {
    const auto row = 3 * static_cast<Eigen::Index>(member);
    const Eigen::Vector3d a = P0.segment<3>(row) + P.middleRows<3>(row) * at;
    return {a(0), a(1), a(2)};
  }
};

}  // namespace tanor
