#pragma once

#include <Eigen/Core>

#include "friction/contact_problem.hpp"

namespace tanor::detail {

/// Returns the motion for fixed limits h [contacts] >= 0: contacts that move have x = h, those at rest solve
///
///   least x'A x/2 + a0'x  with  |x_c| <= h_c                     (Gauss and maximum dissipation, convex)
///
/// The method is a primal-dual interior point method, which needs no guess and is accurate to about 1e-12 of the
/// largest limit.
Eigen::VectorXd solve_convex_law(const ContactProblem& problem, const Eigen::VectorXd& limits);

}  // namespace tanor::detail
