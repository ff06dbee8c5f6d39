#pragma once

/// \file The law of Coulomb friction at rest for beads on straight lines is written down a second time: all motions
/// that
/// obey it are found by dense matrices and homotopy continuation. The code shares nothing with src/.

#include <Eigen/Core>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::reference {

/// Beads at rest on rough lines have accelerations a = a0 + A x along the lines and reactions N = N0 + W x for friction
/// x.
struct RoughContacts {
  struct Motion {
    Eigen::VectorXd x, a;  ///< friction and acceleration along the lines
  };
  struct Counted {
    std::vector<Motion> motions;  ///< of different accelerations
    double margin = 1.0;          ///< least relative distance of a decision from being another one
    bool is_certain = true;       ///< false: a motion depends on how others share their load
  };

  std::vector<double> mu;
  std::vector<Eigen::Index> points;
  std::vector<Eigen::Vector3d> lines;
  Eigen::MatrixXd A, W;
  Eigen::VectorXd a0, N0;

  /// Takes the constraints of kind Lines that a Coulomb entry names, one point each.
  explicit RoughContacts(const System& system, double t = 0.0);

  Eigen::Vector3d normal(Eigen::Index c, const Eigen::VectorXd& x) const;

  /// Tries all subsets of contacts that slide while the others stick; x_j^2 = mu^2 |N_j|^2 has both senses.
  Counted find_all() const;

 private:
  /// Returns the least (mu |N_c| - |x_c|)/(mu |N_c| + |x_c|) of the contacts that stick.
  double slack(const std::vector<Eigen::Index>& stick, const Eigen::VectorXd& x) const;

  /// Returns true if some x + F z has |x_c| <= mu |N_c| at those that stick. `x_found` holds x and becomes the best one
  /// found.
  bool holds(const std::vector<Eigen::Index>& stick, const Eigen::MatrixXd& F, Eigen::VectorXd* x_found,
             Counted* counted) const;
};

}  // namespace tanor::reference
