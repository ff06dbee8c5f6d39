#include <algorithm>
#include <cmath>
#include <numbers>

#include "friction/mode_search.hpp"

/// \file Encloses the law in one node of a ModeSearch between linear inequalities.
namespace tanor::detail {

using Eigen::RowVectorXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using std::numbers::pi;

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
    const Vector2d own = x.segment<2>(contact.first);
    const double size = own.norm(), limit = contact.mu * reaction(c, x).norm();
    if (size <= limit + 0.1 * equal * (1.0 + limit)) continue;
    RowVectorXd row = RowVectorXd::Zero(problem_.size());
    row.segment<2>(contact.first) = own.transpose() / size;
    hold(node, c, row, slide_.empty() ? 1.0 : 0.0, program);
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

void ModeSearch::bound_sticking(const Node& node, std::size_t c, LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  if (!node[c].normal.is_narrow()) return;
  const int directions = contact.dimension == 1 ? 2 : 16;
  for (int i = 0; i < directions; ++i) {
    const Vector2d d = unit_at(2.0 * pi * i / directions);
    RowVectorXd row = d(0) * component(contact.first);
    if (contact.dimension == 2) row += d(1) * component(contact.first + 1);
    hold(node, c, row, slide_.empty() ? 1.0 : 0.0, program);
  }
}

void ModeSearch::bound_on_curve(const Node& node, std::size_t c, LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  if (!contact.moves && node[c].sense == 0) return;
  const RowVectorXd size = sign(node, c) * component(contact.first);
  add(program, -size, 0.0);
  if (!contact.moves) bound_acceleration(-node[c].sense * component(contact.first), program, 1.0);
  bound_reaction(node, c, size, program);
  if (node[c].normal.is_narrow()) hold(node, c, size, 0.0, program);
}

/// Bounds sliding on a surface. |x_c| >= -d.x_c for every d; in a sector |x_c| <= -d_middle.x_c/cos(half), and x_c and
/// a_c stay in it.
void ModeSearch::bound_on_surface(const Node& node, std::size_t c, LinearProgram* program) const {
  const Contact& contact = contacts_[c];
  const Sector &sector = node[c].normal, &towards = node[c].direction;
  constexpr int directions = 16;
  for (int i = 0; sector.is_narrow() && i < directions; ++i)
    hold(node, c, along(contact, unit_at(2.0 * pi * i / directions)), 0.0, program);
  if (towards.is_any()) return;
  const Vector2d d = unit_at(towards.middle), left = unit_at(towards.middle - towards.half + 0.5 * pi),
                 right = unit_at(towards.middle + towards.half - 0.5 * pi);
  for (const Vector2d& n : {left, right}) {
    add(program, along(contact, n), 0.0);
    bound_acceleration(-along(contact, n), program, 0.0);
  }
  bound_acceleration(-along(contact, d), program, 1.0);
  if (sector.is_narrow()) hold(node, c, -along(contact, d), 0.0, program);
  bound_reaction(node, c, -along(contact, d) / std::cos(towards.half), program);
}

LinearProgram ModeSearch::make_program(const Node& node) const {
  LinearProgram program(E_.cols() + 1);
  RowVectorXd last = RowVectorXd::Zero(E_.cols() + 1);
  last(E_.cols()) = 1.0;
  program.add(last, 1.0);
  for (std::size_t c = 0; c < contacts_.size(); ++c) {
    keep_normal(node, c, &program);
    if (std::find(stick_.begin(), stick_.end(), c) != stick_.end())
      bound_sticking(node, c, &program);
    else if (contacts_[c].dimension == 1)
      bound_on_curve(node, c, &program);
    else
      bound_on_surface(node, c, &program);
  }
  return program;
}

}  // namespace tanor::detail
