#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

#include "contact/rough_islands.hpp"

namespace tanor::detail {

/// A motion of contacts that touch and rest along their normals: which of them are closed, and the forces.
struct RoughMotion {
  std::vector<char> is_closed;  ///< [contact]
  Eigen::VectorXd r;            ///< [3 contacts] N
};

struct RoughMotions {
  Uniqueness uniqueness = Uniqueness::Unproven;
  std::string reason;              ///< why there may be others
  std::vector<RoughMotion> found;  ///< different ones
};

/// Finds all motions of an island with the modes open, stick and slip, for accelerations q without contact:
///
///   0 <= r_n _|_ u_n >= 0;   slides, with the direction of `velocities` or of u_t: |r_t| = mu r_n, against it;
///   sticks: u_t = 0, |r_t| <= mu r_n
///
/// Every set of contacts may be closed. Its normal forces are eliminated, and what is left is the ContactProblem of
/// guides that hold, whose motions are searched with N >= 0 (ModeSearch); the other contacts must not close. A contact
/// moves if its component of `velocities` [3 contacts] along its tangents is faster than `rest` [contact]. `work_left`
/// bounds the searches as in find_all().
RoughMotions find_motions(const RoughProblem& problem, const Eigen::VectorXd& velocities,
                          const std::vector<double>& rest, std::size_t work_left, bool is_start);

}  // namespace tanor::detail
