#pragma once

#include <Eigen/Core>
#include <limits>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor::detail {

/// Coulomb contacts of one island with fixed directions of sliding. The unknowns are magnitudes s >= 0,
///
///   s_c = mu_c |N_c|,   N_c = N0_c + sum_j W_cj s_j                          (the absolute value equation of (*))
struct SlidingContacts {
  std::vector<double> mu;           ///< [m]
  Eigen::Matrix3Xd N0;              ///< [3][m]
  std::vector<Eigen::Matrix3Xd> W;  ///< [contact j]: [3][m], the change of each N_c by s_j = 1

  std::size_t size() const { return mu.size(); }
};

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
SlidingSolutions find_sliding(const SlidingContacts& contacts);

/// Adds all solutions by a search in boxes. Returns false if there are too many boxes or a solution is nearly a double
/// one.
bool find_sizes_by_boxes(const SlidingContacts& contacts, std::vector<Eigen::VectorXd>* found);
/// Adds a solution unless it is known.
void add_new(const Eigen::VectorXd& s, std::vector<Eigen::VectorXd>* found);

/// Adds the limit of (43), if it converges, which is certain for rho(R) < 1.
void add_by_iteration(const SlidingContacts& contacts, std::vector<Eigen::VectorXd>* found);

}  // namespace tanor::detail
