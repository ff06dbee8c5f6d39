#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <vector>

#include <tanor/dynamics.hpp>

#include "base/vec3.hpp"
#include "dynamics/instant.hpp"
#include "friction/contact_problem.hpp"

namespace tanor {

/// Below this part of what cancels in it an acceleration is rounding.
inline constexpr double rounding_of_accelerations = 1e-9;
/// A contact that holds this much more than its limit, relative, holds the limit: rounding.
inline constexpr double limit_slack = 1e-12;

/// An instant at which contacts choose their modes: those at rest stick, or begin to slide.
struct ModeSwitch {
  double t;
  const double* r;                      ///< [3n]
  double* v;                            ///< [3n]; what has come to rest is put to rest exactly
  AccelerationOutput to;                ///< [3n] accelerations of the new modes
  Request request;                      ///< of those accelerations
  std::vector<char> at_rest{};          ///< [contact]
  std::vector<std::size_t> releases{};  ///< contacts that stick and have reached their limit
  std::vector<char> has_changed{};      ///< [island] where something is to be chosen

  /// No step before says which of several motions goes on.
  bool is_start() const { return request.refuses_several; }
  std::size_t num_at_rest() const { return static_cast<std::size_t>(std::count(at_rest.begin(), at_rest.end(), 1)); }
  bool is_released(std::size_t contact) const {
    return std::find(releases.begin(), releases.end(), contact) != releases.end();
  }
};

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
  bool has_solution() const { return x.size() > 0; }
  /// Acceleration of the point of a member, m/s^2.
  Vec3 acceleration(std::size_t member, const Eigen::VectorXd& at) const {
    const auto row = 3 * static_cast<Eigen::Index>(member);
    const Eigen::Vector3d a = P0.segment<3>(row) + P.middleRows<3>(row) * at;
    return {a(0), a(1), a(2)};
  }
  /// Components [k] of a member as a vector.
  Vec3 combine(std::size_t member, const Eigen::VectorXd& components) const {
    const ContactProblem::Contact& contact = problem.contacts[member];
    Vec3 sum{};
    for (Eigen::Index k = contact.first; k < contact.first + contact.dimension; ++k)
      sum = sum + components(k) * directions[static_cast<std::size_t>(k)];
    return sum;
  }
  /// mu |N| of a member at x, N.
  double limit(std::size_t member, const Eigen::VectorXd& at) const {
    return problem.contacts[member].mu * problem.normal_force(member, at).norm();
  }
  /// Accelerations below this are rest, m/s^2: the rounding of what cancels at x.
  double rest_threshold() const {
    return rounding_of_accelerations * std::max(acceleration_scale, problem.acceleration_scale(x));
  }
};

}  // namespace tanor
