#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/dense.hpp"
#include "friction/mode_search.hpp"

/// \file The law in one node of a ModeSearch: encloses it between linear inequalities, finds a root of its equations,
/// tests whether there is at most one, and verifies a root.
namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using std::numbers::pi;

double cross(const Vector2d& a, const Vector2d& b) {
  return a(0) * b(1) - a(1) * b(0);
}

/// Returns true if differences from a matrix J of at most D, entry by entry, leave it regular, rho(|J^-1| D) < 1.
bool stays_regular(const MatrixXd& J, const MatrixXd& D) {
  return !std::isnan(ContractionBound().amplification(MatrixXd(dense::Lu(J).inverse().cwiseAbs() * D)));
}

}  // namespace

// ---- linear bounds ----

void ModeSearch::add(LinearProgram* program, const RowVectorXd& row, double bound, double slack) const {
  RowVectorXd all(E_.cols() + 1);
  all << row * E_, slack;
  program->add(all, bound - row.dot(p_));
}

/// Bounds mu |nu_c| around `size`, a linear function of x: n.mu nu <= size <= n.mu nu/cos(half).
void ModeSearch::bound_reaction(const Node& node, std::size_t c, const RowVectorXd& size,
                                LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  const Sector& sector = node[c].normal;
  const auto below = [&](const Vector2d& n) {
    add(program, contact.mu * n.transpose() * contact.V - size, -contact.mu * n.dot(contact.nu0));
  };
  if (sector.is_any()) {
    const int directions = contact.num_normals == 1 ? 2 : 8;
    for (int i = 0; i < directions; ++i) below(unit_at(2.0 * pi * i / directions));
    return;
  }
  below(unit_at(sector.middle));
  if (contact.num_normals == 2) {
    below(unit_at(sector.middle - sector.half));
    below(unit_at(sector.middle + sector.half));
  }
}

/// Adds row x + slack t <= mu |nu_c|, in a narrow sector.
void ModeSearch::hold(const Node& node, std::size_t c, const RowVectorXd& row, double slack,
                      LinearProgram* program) const {
  const Sector& sector = node[c].normal;
  const Vector2d above = contacts_[c].mu / std::cos(sector.half) * unit_at(sector.middle);
  add(program, row - above.transpose() * contacts_[c].V, above.dot(contacts_[c].nu0), slack);
}

/// Refines |x_c| <= mu |nu_c| on surfaces, which begins as a polygon, by one more side for each x outside the circle.
/// Returns true if a side was added.
bool ModeSearch::cut_discs(const Node& node, const VectorXd& x, LinearProgram* program) const {
  bool has_cut = false;
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    const Contact& contact = contacts_[c];
    if (contact.dimension == 1 || !node[c].normal.is_narrow()) continue;
    const Vector2d own = contact.part(x);
    const double size = own.norm(), limit = contact.mu * reaction(c, x).norm();
    if (size <= limit + 0.1 * equal * (1.0 + limit)) continue;
    hold(node, c, contact.along(own / size), slide_.empty() ? 1.0 : 0.0, program);
    has_cut = true;
  }
  return has_cut;
}

/// Adds row a + slack t <= 0.
void ModeSearch::bound_acceleration(const RowVectorXd& row, LinearProgram* program, double slack) const {
  RowVectorXd all(E_.cols() + 1);
  all << row * A_E_, slack;
  program->add(all, -row.dot(a_p_));
}

/// Keeps nu in its sector.
void ModeSearch::keep_normal(const Node& node, std::size_t c, LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  const Sector& sector = node[c].normal;
  if (sector.is_any()) return;
  const auto keep = [&](const Vector2d& n) { add(program, -n.transpose() * contact.V, n.dot(contact.nu0)); };
  if (contact.num_normals == 1) {
    keep(unit_at(sector.middle));
  } else {
    keep(unit_at(sector.middle - sector.half + 0.5 * pi));
    keep(unit_at(sector.middle + sector.half - 0.5 * pi));
  }
}

/// Bounds sliding in a sector of directions d: x_c is in the opposite one, a_c stays in it, and |x_c| <=
/// -d_middle.x_c/cos(half).
void ModeSearch::bound_sliding(const Node& node, std::size_t c, LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  const Sector& towards = node[c].direction;
  if (towards.is_any()) return;
  const RowVectorXd size = -contact.along(unit_at(towards.middle));
  add(program, -size, 0.0);
  for (const double side : {-1.0, 1.0}) {
    const RowVectorXd inside = contact.along(unit_at(towards.middle + side * (towards.half - 0.5 * pi)));
    add(program, inside, 0.0);
    if (!contact.moves) bound_acceleration(-inside, program, 0.0);
  }
  if (!contact.moves) bound_acceleration(size, program, 1.0);
  if (node[c].normal.is_narrow()) hold(node, c, size, 0.0, program);
  bound_reaction(node, c, size / std::cos(towards.half), program);
}

LinearProgram ModeSearch::make_program(const Node& node) const {
  LinearProgram program(E_.cols() + 1);
  program.add(RowVectorXd::Unit(E_.cols() + 1, E_.cols()), 1.0);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    keep_normal(node, c, &program);
    const int directions = contacts_[c].dimension == 1 ? 2 : 16;
    for (int i = 0; node[c].normal.is_narrow() && i < directions; ++i)
      hold(node, c, contacts_[c].along(unit_at(2.0 * pi * i / directions)), slide_.empty() ? 1.0 : 0.0, &program);
    if (!sticks(c)) bound_sliding(node, c, &program);
  }
  return program;
}

// ---- equations ----

/// Solves |x_c| - mu |nu_c| = 0 and, on surfaces, x_c parallel to a_c by Newton's method; z stays.
bool ModeSearch::find_root(const Node& node, VectorXd* x) const {
  constexpr int most_steps = 30;
  const auto q = static_cast<Eigen::Index>(free_.size());
  const MatrixXd E = E_.leftCols(q), A = A_E_.leftCols(q);
  VectorXd F(q);
  MatrixXd J(q, q);
  for (int pass = 0; pass < most_steps; ++pass) {
    const VectorXd a = a0_ + A_ * *x;
    Eigen::Index row = 0;
    for (const std::size_t c : slide_) {
      const Contact& contact = contacts_[c];
      const bool is_on_curve = contact.dimension == 1;
      const Vector2d nu = reaction(c, *x), own = contact.part(*x), towards = contact.part(a);
      const double size = nu.norm();
      const Vector2d n = size > 0.0 ? Vector2d(nu / size) : Vector2d(0.0, 0.0);
      const Vector2d e = is_on_curve ? Vector2d(-unit_at(node[c].direction.middle)) : own.normalized();
      if (!is_on_curve && own.isZero(0.0)) return false;
      F(row) = e.dot(own) - contact.mu * size;
      J.row(row++) = contact.along(e) * E - contact.mu * n.transpose() * contact.V * E;
      if (is_on_curve) continue;
      F(row) = cross(own, towards);
      J.row(row++) = towards(1) * E.row(contact.first) - towards(0) * E.row(contact.first + 1) +
                     own(0) * A.row(contact.first + 1) - own(1) * A.row(contact.first);
    }
    const VectorXd step = dense::solve(J, F);
    if (!step.allFinite()) return false;
    *x -= E * step;
    if (step.norm() <= 1e-14 * x->norm()) return true;
    if (pass + 1 == most_steps) return step.norm() <= 1e-11 * x->norm();
  }
  return false;
}

/// Returns true if the equations of sliding have at most one root in the node. Between two roots the mean J is that of
/// a mean nu, d, x and a.
bool ModeSearch::is_regular(const Node& node, const LinearProgram& program) {
  if (motion_needs_share_) return false;
  const auto q = static_cast<Eigen::Index>(free_.size());
  const MatrixXd E = E_.leftCols(q), A = A_E_.leftCols(q);
  MatrixXd J(q, q), D = MatrixXd::Zero(q, q);
  const auto one_program = static_cast<std::size_t>((E_.cols() + 1) * (E_.cols() + 1));
  // Surfaces need bounds of x_J.
  const bool has_surfaces =
      std::any_of(slide_.begin(), slide_.end(), [&](std::size_t c) { return contacts_[c].dimension > 1; });
  VectorXd middle = VectorXd::Zero(q), radius = VectorXd::Zero(q);
  if (has_surfaces) {
    for (const std::size_t c : slide_) {
      const Sector& direction = node[c].direction;
      if (direction.is_any() || direction.half >= 0.2 * pi || !node[c].normal.is_narrow()) return false;
    }
    for (Eigen::Index i = 0; i < q; ++i) {
      VectorXd u;
      double ends[2];
      for (const int end : {0, 1}) {
        const VectorXd objective = (end == 0 ? -1.0 : 1.0) * VectorXd::Unit(E_.cols() + 1, i);
        work += one_program;
        if (program.maximize(objective, &u) != LinearProgram::Status::Optimal) return false;
        ends[end] = u(i);
      }
      middle(i) = 0.5 * (ends[0] + ends[1]);
      radius(i) = 0.5 * std::abs(ends[1] - ends[0]) * (1.0 + 1e-6) + 1e-12;
    }
  }
  const VectorXd x = p_ + E * middle, a = a_p_ + A * middle, wide_a = A.cwiseAbs() * radius,
                 wide_x = E.cwiseAbs() * radius;
  Eigen::Index row = 0;
  for (const std::size_t c : slide_) {
    const Contact& contact = contacts_[c];
    const Sector& sector = node[c].normal;
    // Means of directions are as near to the middle one as the ends; means of all directions lie within 1 of 0.
    const Vector2d n = sector.is_any() ? Vector2d(0.0, 0.0) : unit_at(sector.middle);
    const double spread = sector.is_any() ? 1.0 : contact.num_normals == 1 ? 0.0 : 2.0 * std::sin(0.5 * sector.half);
    const RowVectorXd dh = contact.mu * n.transpose() * contact.V * E;
    const RowVectorXd wide_h = contact.mu * spread * (contact.V * E).colwise().norm();
    const Eigen::Index first = contact.first;
    const Sector& towards = node[c].direction;
    J.row(row) = -contact.along(unit_at(towards.middle)) * E - dh;
    D.row(row++) =
        wide_h + 2.0 * std::sin(0.5 * towards.half) * E.middleRows(first, contact.dimension).colwise().norm();
    if (contact.dimension == 1) continue;
    J.row(row) = a(first + 1) * E.row(first) - a(first) * E.row(first + 1) + x(first) * A.row(first + 1) -
                 x(first + 1) * A.row(first);
    D.row(row++) = wide_a(first + 1) * E.row(first).cwiseAbs() + wide_a(first) * E.row(first + 1).cwiseAbs() +
                   wide_x(first) * A.row(first + 1).cwiseAbs() + wide_x(first + 1) * A.row(first).cwiseAbs();
  }
  return stays_regular(J, D);
}

bool ModeSearch::is_inside(const Node& node, const VectorXd& x) const {
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    if (!node[c].normal.has(reaction(c, x))) return false;
  }
  return std::all_of(slide_.begin(), slide_.end(),
                     [&](std::size_t c) { return node[c].direction.has(-contacts_[c].part(x)); });
}

ModeSearch::Verdict ModeSearch::verify(const Node& node, const VectorXd& x) const {
  const VectorXd a = a0_ + A_ * x;
  for (const std::size_t c : slide_) {
    const Contact& contact = contacts_[c];
    if (contact.moves) continue;
    const Vector2d towards = contact.part(a);
    const bool is_wrong = contact.dimension == 1 ? unit_at(node[c].direction.middle).dot(towards) <= 0.0
                                                 : contact.part(x).dot(towards) >= 0.0;
    if (is_wrong) return Verdict::SlidesWrongly;
  }
  for (const std::size_t c : stick_) {
    const double limit = contacts_[c].mu * reaction(c, x).norm();
    if (contacts_[c].part(x).norm() > limit + 0.1 * equal) return Verdict::HoldsTooMuch;
  }
  return Verdict::Obeys;
}

}  // namespace tanor::detail
