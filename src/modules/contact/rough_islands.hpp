#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "base/groups.hpp"
#include "dynamics/constrained_system.hpp"
#include "dynamics/workspace.hpp"

namespace tanor::detail {

/// A one-sided row of an island with friction, as a contact: its normal and two tangents, its law and its numbers. A
/// row without friction has a normal alone.
struct RoughContact {
  static constexpr std::size_t none = ~std::size_t{0};

  std::size_t row;             ///< one-sided row
  std::size_t contact = none;  ///< of the friction
  double gradient = 1.0;       ///< |K_a|
  double mu = 0.0;
  std::array<Vec3, 2> tangents{};
  std::array<double, 3> bias{};  ///< m/s^2: accelerations of the contact with w = 0
  double mobility = 0.0;         ///< 1/kg: the largest inverse mass of its points

  bool has_friction() const { return contact != none; }
};

/// The reduced problem of an island at one instant, with all other constraints eliminated:
///
///   u = W r + q,   W = H'(M^-1 - M^-1 K S^-1 K'M^-1) H       (n, t1, t2 of each contact)
///
/// r are forces and u accelerations, or r are impulses and u velocities. Components in which nothing moves have W = 0.
struct RoughProblem {
  std::size_t island = 0;
  std::vector<RoughContact> contacts{};
  Eigen::MatrixXd W{};  ///< [3 contacts][3 contacts]
  Eigen::VectorXd q{};  ///< [3 contacts]

  std::size_t size() const { return contacts.size(); }
  Eigen::Vector2d tangential(std::size_t contact, const Eigen::VectorXd& x) const {
    return x.segment<2>(3 * static_cast<Eigen::Index>(contact) + 1);
  }
  double normal(std::size_t contact, const Eigen::VectorXd& x) const {
    return x(3 * static_cast<Eigen::Index>(contact));
  }
};

/// The islands of one-sided rows that have friction somewhere, and their reduction to contacts.
class RoughIslands {
 public:
  /// All arguments must outlive this object; `arms` [one-sided row] are the blocks of each row.
  RoughIslands(Workspace& work, ConstrainedSystem& system, const Groups<Incidence>& arms);

  bool empty() const { return rows_.empty(); }
  std::size_t size() const { return rows_.size(); }
  /// Returns the one-sided rows of an island.
  const std::vector<std::size_t>& rows(std::size_t island) const { return rows_[island]; }
  /// Returns the friction's contact at a one-sided row, or RoughContact::none.
  std::size_t contact_of(std::size_t row) const { return contact_of_row_[row]; }
  /// Returns the island of a one-sided row, or RoughContact::none without friction.
  std::size_t island_of(std::size_t row) const { return island_of_row_[row]; }

  std::size_t island_of_contact(std::size_t contact) const { return island_of_contact_[contact]; }

  /// Takes the normals, the tangents and the biases of all rows that `take_part` [one-sided row] from (t, r, v), where
  /// they must be closed.
  void measure(const double* r, const double* v, std::span<const char> take_part);
  /// Returns the problems of the rows that were measured, with q = 0, by the factor of S in which they are open.
  std::vector<RoughProblem> reduce();
  /// Sets q to the velocities of the contacts at v, or to their accelerations without friction and contact at (t, r,
  /// v).
  void set_velocities(const double* r, const double* v, std::vector<RoughProblem>* problems) const;
  void set_accelerations(double t, const double* r, const double* v, std::vector<RoughProblem>* problems);
  /// Adds the velocities that impulses P [problem] of the contacts make, to v [3n]. Returns the multipliers of the
  /// other rows, N s.
  std::vector<double> strike(const std::vector<RoughProblem>& problems, const std::vector<Eigen::VectorXd>& P,
                             double* v);
  /// Returns the forces [3 contacts] of the rows' multipliers and the friction at its contacts.
  Eigen::VectorXd forces(const RoughProblem& problem, const double* lambda, const std::vector<double>& friction) const;

 private:
  void push(const RoughContact& contact, int component, double size, double* w) const;
  double pull(const RoughContact& contact, int component, const double* x) const;
  double sign(std::size_t row) const { return model_.numbering.one_sided[row].sign; }
  std::size_t inner_row(std::size_t row) const { return static_cast<std::size_t>(model_.numbering.one_sided[row].row); }
  /// Adds what the other constraints answer to accelerations w [3n] of moving points.
  void respond(double* w);

  Workspace& work_;
  const Model& model_;
  ConstrainedSystem& system_;
  const Groups<Incidence>& arms_;
  std::vector<std::vector<std::size_t>> rows_;               // [island]
  std::vector<std::size_t> contact_of_row_, island_of_row_;  // [one-sided row]
  std::vector<std::size_t> island_of_contact_;               // [contact]
  std::vector<RoughProblem> measured_;
  std::vector<double> blocks_;           // K where contacts were measured
  std::vector<double> b_, lambda_, dw_;  // scratch
};

}  // namespace tanor::detail
