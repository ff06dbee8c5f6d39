#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

#include "friction/contact_problem.hpp"
#include "friction/linear_program.hpp"

namespace tanor {

/// All motions of a ContactProblem by branch and bound.
///
/// A subset S of the contacts sticks, a = 0, and the others slide. What sticks is eliminated, x = p + Q x_J + F z,
/// where z tells how a load is shared. A node of the search leaves each contact a sector of directions that its
/// reaction nu may have, and each one that slides a sense (on a curve) or a sector of directions (on a surface). In a
/// node the law
///
///   slides: |x_c| = mu |nu_c|, a_c against x_c;     sticks: |x_c| <= mu |nu_c|
///
/// lies between linear inequalities, for n.nu <= |nu| <= n_middle.nu/cos(half) in a sector. Where these have no
/// solution, the law has none. Where the equations of sliding are regular in the whole sector, they have one solution
/// at most, and Newton's method finds it. Otherwise a sector is cut in two.
class ModeSearch {
 public:
  ModeSearch(const ContactProblem& problem, std::size_t most_work);

  /// Looks everywhere; afterwards `found` holds a solution x of each motion, and perhaps the same one again.
  void run();

  std::vector<Eigen::VectorXd> found;
  std::string reason;    ///< why there may be others; empty: there are none
  std::size_t work = 0;  ///< unknowns^2 of all linear programs

 private:
  /// Directions at most `half` from `middle`, rad; half < 0: any.
  struct Sector {
    double middle = 0.0, half = -1.0;
    bool is_any() const { return half < 0.0; }
    bool is_narrow() const;  // the bound from above is worth something
    bool has(const Eigen::Vector2d& direction) const;
  };
  struct Piece {
    int sense = 0;             // of the acceleration, on a curve; 0: either
    Sector normal, direction;  // of nu; of the acceleration, on a surface
  };
  using Node = std::vector<Piece>;  // [contact]
  struct Contact {
    Eigen::Index first, dimension;
    bool moves, is_rough;
    double mu;
    int num_normals;  // 1: nu keeps to a line, 2: to a plane
    Eigen::Vector2d nu0;
    Eigen::Matrix2Xd V;  // nu = nu0 + V x
  };
  static constexpr double equal = 1e-9;  // in units: less is 0
  static Eigen::Vector2d unit_at(double angle) { return {std::cos(angle), std::sin(angle)}; }
  enum class Verdict { Obeys, SlidesWrongly, HoldsTooMuch };

  void set_contacts();
  bool stick(std::size_t subset);
  void search();
  void visit(const Node& node);
  Eigen::VectorXd come_near(const Node& node, Eigen::VectorXd x);

  // Linear bounds, in mode_bounds.cpp.
  LinearProgram make_program(const Node& node) const;
  void keep_normal(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_sticking(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_on_curve(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_on_surface(const Node& node, std::size_t c, LinearProgram* program) const;
  void bound_acceleration(const Eigen::RowVectorXd& row, LinearProgram* program, double slack) const;
  void bound_reaction(const Node& node, std::size_t c, const Eigen::RowVectorXd& size, LinearProgram* program) const;
  void hold(const Node& node, std::size_t c, const Eigen::RowVectorXd& row, double slack, LinearProgram* program) const;
  bool cut_discs(const Node& node, const Eigen::VectorXd& x, LinearProgram* program) const;
  void add(LinearProgram* program, const Eigen::RowVectorXd& row, double bound, double slack = 0.0) const;

  // The law itself, in mode_equations.cpp.
  bool find_root(const Node& node, Eigen::VectorXd* x) const;
  bool is_regular(const Node& node, const LinearProgram& program);
  bool is_inside(const Node& node, const Eigen::VectorXd& x) const;
  Verdict verify(const Node& node, const Eigen::VectorXd& x) const;

  bool branch(const Node& node, const Eigen::VectorXd& x);

  Eigen::Vector2d reaction(std::size_t c, const Eigen::VectorXd& x) const {
    return contacts_[c].nu0 + contacts_[c].V * x;
  }
  double sign(const Node& node, std::size_t c) const { return contacts_[c].moves ? 1.0 : -node[c].sense; }
  Eigen::VectorXd complete(const Eigen::VectorXd& u) const;
  Eigen::RowVectorXd component(Eigen::Index i) const { return Eigen::RowVectorXd::Unit(problem_.size(), i); }
  Eigen::RowVectorXd along(const Contact& contact, const Eigen::Vector2d& d) const {
    return d(0) * component(contact.first) + d(1) * component(contact.first + 1);
  }

  const ContactProblem& problem_;
  const std::size_t most_work_;
  double unit_ = 1.0;  // N
  Eigen::MatrixXd A_;  // scaled: accelerations over their scale, forces over the unit
  Eigen::VectorXd a0_;
  std::vector<Contact> contacts_;
  bool turns_in_space_ = false;
  // The subset that is looked at.
  std::vector<std::size_t> stick_, slide_;
  std::vector<Eigen::Index> free_;  // components of those that slide
  Eigen::VectorXd p_;
  Eigen::MatrixXd E_;    // [Q F]
  Eigen::VectorXd a_p_;  // a = a_p + A_E u
  Eigen::MatrixXd A_E_;
  bool motion_needs_share_ = false, is_finished_ = false;
  std::vector<Node> open_;
};

}  // namespace tanor
