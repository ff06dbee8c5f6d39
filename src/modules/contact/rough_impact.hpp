#pragma once

#include <Eigen/Core>

#include "contact/rough_islands.hpp"

namespace tanor::detail {

struct RoughImpact {
  Eigen::VectorXd P;         ///< [3 contacts] impulses, N s
  double energy_change = 0;  ///< J, of the motion relative to the guides: P'(u- + u+)/2
  bool is_capped = false;    ///< restitution was lowered to what feeds no energy
  double error = 0.0;        ///< error_of_contacts()
};

/// Solves the impact of contacts with the velocities q before it, by Newton's law along normals and a plastic one along
/// tangents:
///
///   u+ = W P + q,   K_mu contains P,   (u_n+ + e u_n-, u_t+) is complementary to it as in ConeProblem
///
/// With friction and e > 0 this may feed energy (Kane and Levinson 1985). Then the largest part of all e is taken that
/// does not, which exists since e = 0 never does. `restitution` [contact] is e, 0 where a contact does not approach.
RoughImpact solve_impact(const RoughProblem& problem, const Eigen::VectorXd& restitution);

/// Solves the impact of contacts that touch at rest along their normals, and jam: the impulses which are not 0, found
/// from slow approaches, ever slower. P is 0 where there are none.
RoughImpact solve_jam(const RoughProblem& problem);

/// Solves u_n+ = 0 for contacts whose normals separate so slowly that they are taken to be closed: those that move keep
/// the friction of their slide, r_t = -mu r_n u_t/|u_t|, also where r_n pulls, and those slower than `rest` do not
/// slip.
RoughImpact solve_slow_flight(const RoughProblem& problem, double rest);

}  // namespace tanor::detail
