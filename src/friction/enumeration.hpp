#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor {

/// Coulomb contacts of one island with the directions of sliding fixed: unknown magnitudes s >= 0,
///
///   s_c = mu_c |N_c|,   N_c = N0_c + sum_j W_cj s_j                          (the absolute value equation of (*))
struct SlidingContacts {
  std::vector<double> mu;           ///< [m]
  Eigen::Matrix3Xd N0;              ///< [3][m]
  std::vector<Eigen::Matrix3Xd> W;  ///< [contact j]: [3][m], what s_j = 1 does to each N_c

  std::size_t size() const { return mu.size(); }
};

struct SlidingSolutions {
  Uniqueness uniqueness = Uniqueness::Unproven;
  /// Where rho(R) < 1, R_cj = mu_c |W_cj|: largest row sum of (I - R)^-1. Then (43) has one solution, converges to it,
  /// and |s - s*| <= amplification |F(s) - s|: 1/(1 - L) with L = 1 - 1/amplification. Else NaN.
  double amplification = std::numeric_limits<double>::quiet_NaN();
  /// The solutions s [m] that trying found, each once; none where rho(R) < 1 says enough, or nothing could be tried.
  std::vector<Eigen::VectorXd> found;
  bool is_complete = false;          ///< there are no others than `found`
  bool determinant_changes = false;  ///< det(I - diag(mu n) W) changes its sign over the signs n: Painleve
};

constexpr std::size_t most_enumerated = 10;
constexpr std::size_t few_boxes = 300;

/// Theorem B of the theory: rho < 1; else, for up to `most_enumerated` contacts, all signs where each normal force
/// keeps to one line, a quadratic equation for one contact on a wire, corners of polygons around the circles of normal
/// directions otherwise (which may prove uniqueness), and boxes where these change the sign.
SlidingSolutions find_sliding(const SlidingContacts& contacts, std::size_t most_boxes = few_boxes);

/// Adds all solutions, by boxes; false: boxes became too many, or a solution is too nearly a double one.
bool find_sizes_by_boxes(const SlidingContacts& contacts, std::size_t most_boxes, std::vector<Eigen::VectorXd>* found);

/// Adds what (43) itself converges to, if it does: certain where rho < 1.
void add_by_iteration(const SlidingContacts& contacts, std::vector<Eigen::VectorXd>* found);

}  // namespace tanor
