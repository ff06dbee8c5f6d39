#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor {

/// Coulomb contacts of one island at one instant, with everything else eliminated. Unknown: the friction x [k], of each
/// contact at rest its components along the tangents of its guide, of each contact that moves its size against the
/// sliding. Reactions and accelerations along the components answer linearly,
///
///   N = N0 + W x  [3 a contact],   a = a0 + A x  [k],   A = A' >= 0 among contacts at rest,
///
/// and the law asks of contact c, with h = mu |N_c|,
///
///   moving: x = h;     at rest: |x_c| <= h,  and x_c = -h a_c/|a_c| where a_c is not 0.
struct ContactProblem {
  struct Contact {
    Eigen::Index first = 0;      ///< of its components
    Eigen::Index dimension = 1;  ///< at rest on a surface 2; else 1
    bool moves = false;
    double mu = 0.0;
  };
  std::vector<Contact> contacts;
  Eigen::MatrixXd A, W;    ///< [k][k]; [3 contacts][k]
  Eigen::VectorXd a0, N0;  ///< [k]; [3 contacts]

  Eigen::Index size() const { return a0.size(); }
  Eigen::Vector3d normal_force(std::size_t contact, const Eigen::VectorXd& x) const {
    const auto row = 3 * static_cast<Eigen::Index>(contact);
    return N0.segment<3>(row) + W.middleRows<3>(row) * x;
  }
  Eigen::VectorXd accelerations(const Eigen::VectorXd& x) const { return a0 + A * x; }
  /// Largest term that cancels in the accelerations, m/s^2.
  double acceleration_scale(const Eigen::VectorXd& x) const;

  /// How far x is from the law: of each contact |x - P(x - a/A_cc)| for P the projection onto |x| <= h, the largest,
  /// over the largest h. 0 exactly at solutions.
  double residual(const Eigen::VectorXd& x) const;
  /// Two solutions are one motion.
  bool are_same(const Eigen::VectorXd& x, const Eigen::VectorXd& y) const;
};

/// The solutions of a problem, as far as they were looked for.
struct ContactSolutions {
  Uniqueness uniqueness = Uniqueness::Unproven;
  std::vector<Eigen::VectorXd> found;  ///< x, different motions
  std::string reason;                  ///< why uniqueness is unproven
};

/// Accelerations are unique: friction changes no reaction (a convex problem, Moreau), or changes them by little:
///
///   sum of mu_c |A_c y| |W_c y| < y'A y for all y                        (y: the difference of two solutions)
///
/// For contacts at rest, and moving ones whose reactions friction does not change.
bool is_monotone(const ContactProblem& problem);

constexpr std::size_t most_contacts_counted = 10;

/// All motions that obey the law, all modes of stick and slip tried by ModeSearch: complete for up to
/// `most_contacts_counted` contacts, unless that takes more than `most_work`, the sum of
/// unknowns^2 of linear programs. `guess`: where
/// to look first.
ContactSolutions find_all(const ContactProblem& problem, std::size_t most_work, const Eigen::VectorXd& guess);

/// Some motion that obeys the law, near `guess`; empty: none was found. A semismooth Newton method, then limits mu |N|
/// that stand by turns with the convex problem that they leave. Certified by its residual.
Eigen::VectorXd find_one(const ContactProblem& problem, const Eigen::VectorXd& guess);

/// Contacts at rest that may share their load in many ways share it at the analytic centre of what obeys the law: the
/// largest product of h_c^2 - |x_c|^2, where h_c may depend on the share itself. Where nothing does, limits are raised
/// until something does. Changes x to that share; others than `shares_it` [contact] keep their friction and their
/// reactions. Returns the largest load (1: |x_c| = h_c); NaN: there is one share only.
/// While the load changes, the centre changes by the least norm with the `weights` [contact], largest 1.
/// `prefers_least`: the least share of all, with weights that are alike, where it obeys the law with a tenth to spare.
double share_load(const ContactProblem& problem, const std::vector<char>& shares_it, bool prefers_least,
                  Eigen::VectorXd* x, Eigen::VectorXd* weights);

constexpr double obeys_below = 1e-9;  ///< residuals of what counts as a solution

}  // namespace tanor
