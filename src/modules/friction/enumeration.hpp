#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include "friction/contact_problem.hpp"

namespace tanor::detail {

/// The sizes of friction s >= 0 of the contacts of one island that all slide in fixed directions, which solve the
/// absolute value equation of (*), s_c = mu_c |N_c(s)|.
struct SlidingSolutions {
  Uniqueness uniqueness = Uniqueness::Unproven;
  /// The largest row sum of (I - R)^-1 if rho(R) < 1, R_cj = mu_c |W_cj|, else NaN. If rho(R) < 1, (43) has one
  /// solution, converges to it, and |s - s*| <= amplification |F(s) - s|, which is 1/(1 - L) with L = 1 -
  /// 1/amplification.
  double amplification = std::numeric_limits<double>::quiet_NaN();
  /// The solutions s [m] that the enumeration found, each once; empty if rho(R) < 1, or if nothing could be tried.
  std::vector<Eigen::VectorXd> found;
  bool is_complete = false;          ///< true if there are no others than `found`
  bool determinant_changes = false;  ///< true if det(I - sigma mu n.W) changes its sign over the signs (Painleve)
};

constexpr std::size_t most_enumerated = 10;

/// Proves uniqueness by rho(R) < 1 or finds the solutions. For up to `most_enumerated` contacts it tries all signs if
/// each normal force keeps to one line, else it searches boxes.
SlidingSolutions find_sliding(const ContactProblem& problem);

/// Adds all solutions by a search in boxes. Returns false if there are too many boxes or a solution is nearly a double
/// one.
bool find_sizes_by_boxes(const ContactProblem& problem, std::vector<Eigen::VectorXd>* found);
/// Adds a solution unless it is known.
void add_new(const Eigen::VectorXd& s, std::vector<Eigen::VectorXd>* found);

}  // namespace tanor::detail
