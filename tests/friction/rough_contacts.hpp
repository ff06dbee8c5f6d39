#pragma once

/// \file The law of Coulomb friction at rest for beads on straight lines, written down a second time: all motions that
/// obey it, by dense matrices and homotopy continuation. It shares nothing with src/.

#include <Eigen/Core>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::reference {

/// Beads at rest on rough lines: accelerations along the lines a = a0 + A x, reactions N = N0 + W x for friction x.
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

  /// Constraints of kind Lines with a Coulomb entry of their name, one point each.
  explicit RoughContacts(const System& system, double t = 0.0);

  Eigen::Vector3d normal(Eigen::Index c, const Eigen::VectorXd& x) const;

  /// Subsets of contacts that slide, the others stick: x_j^2 = mu^2 |N_j|^2 has both senses.
  Counted find_all() const;

 private:
  /// The least of (mu |N_c| - |x_c|)/(mu |N_c| + |x_c|).
  double slack(const std::vector<Eigen::Index>& stick, const Eigen::VectorXd& x) const;

  /// Some x + F z has |x_c| <= mu |N_c| at those that stick: then x becomes that one.
  bool holds(const std::vector<Eigen::Index>& stick, const Eigen::MatrixXd& F, Eigen::VectorXd* x_found,
             Counted* counted) const;
};

}  // namespace tanor::reference
