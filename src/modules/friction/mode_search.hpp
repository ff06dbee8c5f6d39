#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "friction/contact_problem.hpp"
#include "friction/linear_program.hpp"

namespace tanor::detail {

/// Finds all motions of a ContactProblem by branch and bound.
///
/// A subset S of the contacts sticks, a = 0, and the others slide. The sticking contacts are eliminated, x = p + Q x_J
/// + F z, where z tells how a load is shared. A node of the search assigns to each contact a sector of directions of
/// its reaction nu, and to each one that slides a sector of directions of its acceleration, which is one sense on a
/// curve. In a node the law
///
///   slides: |x_c| = mu |nu_c|, a_c against x_c;     sticks: |x_c| <= mu |nu_c|
///
/// lies between linear inequalities, since n.nu <= |nu| <= n_middle.nu/cos(half) in a sector. If the inequalities have
/// no solution, the law has none. If the equations of sliding are regular in the whole sector, they have at most one
/// solution, and Newton's method finds it. Otherwise a sector is cut in two.
class ModeSearch {
 public:
  ModeSearch(const ContactProblem& problem, std::size_t most_work);

  /// Searches everything. Afterwards `found` holds a solution x of each motion, perhaps with repetitions.
  void run();

  std::vector<Eigen::VectorXd> found;
  std::string reason;    ///< why there may be others; empty if there are none
  std::size_t work = 0;  ///< unknowns^2 of all linear programs and eigenproblems

 private:
  /// Directions at most `half` from `middle`, rad; half < 0 means any direction.
  struct Sector {
    double middle = 0.0, half = -1.0;
    bool is_any() const { return half < 0.0; }
    bool is_narrow() const { return !is_any() && half <= 0.26 * std::numbers::pi; }  // the bound from above is useful
    bool has(const Eigen::Vector2d& direction) const;
  };
  struct Piece {
    Sector normal, direction;  // of nu, and of the acceleration: its sense 0 or pi on a curve
  };
  using Node = std::vector<Piece>;  // [contact]
  struct Contact {
    Eigen::Index first, dimension;
    bool moves, is_rough;
    double mu;
    int num_normals;  // 1 if nu keeps to a line, 2 if to a plane
    Eigen::Vector2d nu0;
    Eigen::Matrix2Xd V;    // nu = nu0 + V x
    double outward = 0.0;  // the sign of nu where the guide acts to one side

    /// Returns its components of x as a vector, whose second number is 0 on a curve.
    Eigen::Vector2d part(const Eigen::VectorXd& x) const { return {x(first), dimension == 2 ? x(first + 1) : 0.0}; }
    /// Returns the row that makes d.x_c of x.
    Eigen::RowVectorXd along(const Eigen::Vector2d& d) const {
      Eigen::RowVectorXd row = Eigen::RowVectorXd::Zero(V.cols());
      row.segment(first, dimension) = d.head(dimension).transpose();
      return row;
    }
  };
  static constexpr double equal = 1e-9;  // in scaled units; less counts as 0
  static Eigen::Vector2d unit_at(double angle) { return {std::cos(angle), std::sin(angle)}; }
  enum class Verdict { Obeys, SlidesWrongly, HoldsTooMuch };

  void set_contacts();
  bool stick(std::size_t subset);
  void search();
  void visit(const Node& node);
  void prefer_small_shares(LinearProgram program, Eigen::VectorXd* u);
  Eigen::VectorXd come_near(const Node& node, Eigen::VectorXd x) const;

  bool branch(const Node& node, const Eigen::VectorXd& x);
  void cut(const Node& node, std::size_t c, Sector Piece::*which, bool is_line);

  // In mode_law.cpp: linear bounds of the law, and the law itself.
  LinearProgram make_program(const Node& node) const;
  void keep_normal(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_sliding(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_acceleration(const Eigen::RowVectorXd& row, LinearProgram* program, double slack) const;
  void bound_reaction(const Node& node, std::size_t c, const Eigen::RowVectorXd& size, LinearProgram* program) const;
  void hold(const Node& node, std::size_t c, const Eigen::RowVectorXd& row, double slack, LinearProgram* program) const;
  bool cut_discs(const Node& node, const Eigen::VectorXd& x, LinearProgram* program) const;
  void add(LinearProgram* program, const Eigen::RowVectorXd& row, double bound, double slack = 0.0) const;
  bool find_root(const Node& node, Eigen::VectorXd* x) const;
  bool is_regular(const Node& node, const LinearProgram& program);
  bool is_inside(const Node& node, const Eigen::VectorXd& x) const;
  Verdict verify(const Node& node, const Eigen::VectorXd& x) const;

  Eigen::Vector2d reaction(std::size_t c, const Eigen::VectorXd& x) const {
    return contacts_[c].nu0 + contacts_[c].V * x;
  }
  bool sticks(std::size_t c) const { return std::find(stick_.begin(), stick_.end(), c) != stick_.end(); }
  /// Returns x of u = (x_J, z).
  Eigen::VectorXd complete(const Eigen::VectorXd& u) const { return p_ + E_ * u.head(E_.cols()); }

  const ContactProblem& problem_;
  const std::size_t most_work_;
  double unit_ = 1.0;  // N
  Eigen::MatrixXd A_;  // scaled: accelerations over their scale, forces over the unit
  Eigen::VectorXd a0_;
  std::vector<Contact> contacts_;
  bool turns_in_space_ = false;
  // The present subset.
  std::vector<std::size_t> stick_, slide_;
  std::vector<Eigen::Index> free_;  // components of the contacts that slide
  Eigen::VectorXd p_;
  Eigen::MatrixXd E_;    // [Q F]
  Eigen::VectorXd a_p_;  // a = a_p + A_E u
  Eigen::MatrixXd A_E_;
  bool motion_needs_share_ = false, is_finished_ = false;
  std::vector<Node> open_;
};

}  // namespace tanor::detail
