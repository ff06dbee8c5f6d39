#include <algorithm>
#include <cmath>
#include <numbers>

#include "friction/mode_search.hpp"

#include "base/dense.hpp"

/// \file Solves the law in one node of a ModeSearch as equations: finds a root, tests whether there is at most one, and
/// verifies a root.
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
      const Vector2d nu = reaction(c, *x);
      const double size = nu.norm();
      const RowVectorXd dh =
          contact.mu * (size > 0.0 ? (nu / size).eval() : Vector2d::Zero().eval()).transpose() * contact.V * E;
      if (contact.dimension == 1) {
        F(row) = sign(node, c) * (*x)(contact.first) - contact.mu * size;
        J.row(row++) = sign(node, c) * E.row(contact.first) - dh;
        continue;
      }
      const Vector2d own = x->segment<2>(contact.first), towards = a.segment<2>(contact.first);
      const double length = own.norm();
      if (length == 0.0) return false;
      F(row) = length - contact.mu * size;
      J.row(row++) = own.transpose() / length * E.middleRows<2>(contact.first) - dh;
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
      const bool is_cut =
          contacts_[c].dimension == 1 || (node[c].direction.half >= 0.0 && node[c].direction.half < 0.2 * pi);
      if (!is_cut || !node[c].normal.is_narrow()) return false;
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
    if (contact.dimension == 1) {
      J.row(row) = sign(node, c) * E.row(first) - dh;
      D.row(row++) = wide_h;
      continue;
    }
    const Sector& towards = node[c].direction;
    J.row(row) = -unit_at(towards.middle).transpose() * E.middleRows<2>(first) - dh;
    D.row(row++) = wide_h + 2.0 * std::sin(0.5 * towards.half) * E.middleRows<2>(first).colwise().norm();
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
  return std::all_of(slide_.begin(), slide_.end(), [&](std::size_t c) {
    if (contacts_[c].dimension == 1) return sign(node, c) * x(contacts_[c].first) >= -equal;
    return node[c].direction.has(-x.segment<2>(contacts_[c].first));
  });
}

ModeSearch::Verdict ModeSearch::verify(const Node& node, const VectorXd& x) const {
  const VectorXd a = a0_ + A_ * x;
  for (const std::size_t c : slide_) {
    const Contact& contact = contacts_[c];
    if (contact.moves) continue;
    const VectorXd own = x.segment(contact.first, contact.dimension),
                   towards = a.segment(contact.first, contact.dimension);
    const bool is_wrong = contact.dimension == 1 ? node[c].sense * towards(0) <= 0.0 : own.dot(towards) >= 0.0;
    if (is_wrong) return Verdict::SlidesWrongly;
  }
  for (const std::size_t c : stick_) {
    const double limit = contacts_[c].mu * reaction(c, x).norm();
    if (x.segment(contacts_[c].first, contacts_[c].dimension).norm() > limit + 0.1 * equal)
      return Verdict::HoldsTooMuch;
  }
  return Verdict::Obeys;
}

}  // namespace tanor::detail
