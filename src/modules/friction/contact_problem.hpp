#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include <tanor/dynamics.hpp>

namespace tanor::detail {

/// Coulomb contacts of one island at one instant, with everything else eliminated. The unknown is the friction x [k]:
/// for each contact at rest its components along the tangents of its guide, for each contact that moves its size
/// against the sliding. Reactions and accelerations along the components depend on x linearly,
///
///   N = N0 + W x  [3 a contact],   a = a0 + A x  [k],   A = A' >= 0 among contacts at rest,
///
/// and the law asks of contact c, with h = mu |N_c|,
///
///   moving: x = h;     at rest: |x_c| <= h,  and x_c = -h a_c/|a_c| where a_c is not 0.
///
/// A guide to one side asks for N.outward >= 0 as well.
struct ContactProblem {
  struct Contact {
    Eigen::Index first = 0;      ///< first of its components
    Eigen::Index dimension = 1;  ///< 2 for a contact at rest on a surface, else 1
    bool moves = false;
    double mu = 0.0;
  };
  std::vector<Contact> contacts;
  Eigen::MatrixXd A, W;                    ///< [k][k]; [3 contacts][k]
  Eigen::VectorXd a0, N0;                  ///< [k]; [3 contacts]
  std::vector<Eigen::Vector3d> outward{};  ///< [contact] 0 where the guide acts to both sides; empty if all do

  Eigen::Index size() const { return a0.size(); }
  Eigen::Vector3d normal_force(std::size_t contact, const Eigen::VectorXd& x) const {
    const auto row = 3 * static_cast<Eigen::Index>(contact);
    return N0.segment<3>(row) + W.middleRows<3>(row) * x;
  }
  /// Returns mu |N| of a contact at x, N.
  double limit(std::size_t contact, const Eigen::VectorXd& x) const {
    return contacts[contact].mu * normal_force(contact, x).norm();
  }
  double mobility(std::size_t contact) const;  ///< A_cc
  bool is_one_sided(std::size_t contact) const { return !outward.empty() && !outward[contact].isZero(0.0); }
  /// Returns true if a guide to one side would pull at x.
  bool pulls(const Eigen::VectorXd& x) const;
  Eigen::VectorXd accelerations(const Eigen::VectorXd& x) const { return a0 + A * x; }
  /// Returns the largest term that cancels in the accelerations, m/s^2.
  double acceleration_scale(const Eigen::VectorXd& x) const;

  /// Returns the law as equations (Alart and Curnier 1991): x - h of a contact that moves, and x - P(x - a/A_cc) of one
  /// at rest, where P is the projection onto |x| <= h. Writes their derivative by x for accelerations a = a0 + A x,
  /// unless J is null.
  Eigen::VectorXd defect(const Eigen::VectorXd& x, const Eigen::VectorXd& a, double least_mobility,
                         Eigen::MatrixXd* J) const;
  /// Returns how far x is from the law: the largest defect of all contacts, over the largest of |x|, h and |a0|/A_cc.
  /// It is 0 exactly at solutions.
  double residual(const Eigen::VectorXd& x) const;
  /// Returns true if two solutions are the same motion.
  bool are_same(const Eigen::VectorXd& x, const Eigen::VectorXd& y) const;
};

/// The solutions of a problem that were found.
struct ContactSolutions {
  Uniqueness uniqueness = Uniqueness::Unproven;
  std::vector<Eigen::VectorXd> found;  ///< x of different motions
  bool is_complete = false;            ///< there are no others than `found`
  std::string reason;                  ///< why there may be others
};

/// Proves by contraction that contacts which all move have one solution of x = h(x), that is, of (43). The workspace is
/// kept, since every step asks.
class ContractionBound {
 public:
  /// Returns the largest row sum of (I - R)^-1, R_cj = mu_c |W_cj|, if rho(R) < 1, else NaN. If rho(R) < 1, (43) has
  /// one solution, converges to it, and |x - x*| <= amplification |h(x) - x|, which is 1/(1 - L) with L = 1 -
  /// 1/amplification.
  double amplification(const ContactProblem& problem);
  /// Returns the same for any R >= 0 [m, m].
  double amplification(const Eigen::MatrixXd& R);

 private:
  Eigen::MatrixXd R_, A_;  // [m][m]; A = I - R, then its factors
  Eigen::VectorXd x_;      // [m]
};

/// Returns true if accelerations are unique, since (43) is a contraction of contacts that all move, or since friction
/// changes no reaction (a convex problem, Moreau) or changes them by little:
///
///   sum of mu_c |A_c y| |W_c y| < y'A y for all y                        (y: the difference of two solutions)
///
/// The latter holds for contacts at rest, and for moving ones whose reactions friction does not change.
bool is_proven_unique(const ContactProblem& problem);

constexpr std::size_t most_contacts_counted = 10;
/// The work that the searches of one island at one instant may take: 0.6 s of a slow processor at a start, some
/// hundredths of a second in the middle of a run.
constexpr std::size_t most_work(bool is_start) {
  return is_start ? 500000 : 40000;
}

/// Finds all motions that obey the law by trying all modes of stick and slip in a ModeSearch, or all signs where every
/// contact moves and its normal force keeps to a line. The result is complete for up to `most_contacts_counted`
/// contacts, unless the search takes more than `*work_left`, the sum of unknowns^2 of linear programs and
/// eigenproblems, from which it takes what it used. `guess` is the first start of Newton's method, which is used where
/// a search is not needed or not complete; in the latter case it has `other_starts`, too.
ContactSolutions find_all(const ContactProblem& problem, std::size_t* work_left, const Eigen::VectorXd& guess,
                          int other_starts = 16);

/// Finds some motion that obeys the law, near `guess`; empty if none was found. A semismooth Newton method is tried
/// first. Then the limits mu |N| and the convex problem for fixed limits are solved in turn. The result is certified by
/// its residual.
Eigen::VectorXd find_one(const ContactProblem& problem, const Eigen::VectorXd& guess);

/// Returns the motion for fixed limits h [contacts] >= 0: contacts that move have x = h, those at rest solve
///
///   least x'A x/2 + a0'x  with  |x_c| <= h_c                     (Gauss and maximum dissipation, convex)
///
/// The method is a primal-dual interior point method, which needs no guess and is accurate to about 1e-12 of the
/// largest limit.
Eigen::VectorXd solve_convex_law(const ContactProblem& problem, const Eigen::VectorXd& limits);

/// Chooses the share of a load that contacts at rest may share in many ways: the analytic centre of what obeys the law,
/// where the product of h_c^2 - |x_c|^2 is largest; h_c may depend on the share itself. If no share obeys the law,
/// limits are raised until one does. Changes x to that share; contacts other than `shares_it` [contact] keep their
/// friction and their reactions. Returns the largest load (1 for |x_c| = h_c), or NaN if there is only one share.
/// Writes the `weights` [contact], largest 1, of the norm in which the centre changes least while the load changes. If
/// `prefers_least` is true, chooses the least share of all, with equal weights, provided that it obeys the law with a
/// tenth to spare.
double share_load(const ContactProblem& problem, const std::vector<char>& shares_it, bool prefers_least,
                  Eigen::VectorXd* x, Eigen::VectorXd* weights);

constexpr double obeys_below = 1e-9;  ///< largest residual of what counts as a solution

}  // namespace tanor::detail
