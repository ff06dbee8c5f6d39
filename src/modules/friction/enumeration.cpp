#include "friction/enumeration.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/dense.hpp"
#include "friction/contraction.hpp"

namespace tanor::detail {

namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// The directions that the normal force of one contact can take.
struct Directions {
  int dimension;  // 1 for a line, 2 for a plane, 3 for space
  Vector3d first, second;
};

Directions find_directions(const SlidingContacts& contacts, Eigen::Index c) {
  const auto m = static_cast<Eigen::Index>(contacts.size());
  Matrix3Xd all(3, m + 1);
  all.col(0) = contacts.N0.col(c);
  for (Eigen::Index j = 0; j < m; ++j) all.col(j + 1) = contacts.W[static_cast<std::size_t>(j)].col(c);
  for (Eigen::Index k = 0; k <= m; ++k) {
    const double length = all.col(k).norm();
    if (length > 0.0) all.col(k) /= length;
  }
  const auto [sigma, U, V] = dense::find_singular_values_and_U(all);
  constexpr double rounding = 1e-11;
  const auto is_zero = [&sigma = sigma](Eigen::Index k) {
    return sigma.size() <= k || sigma(k) <= rounding * sigma(0);
  };
  return {is_zero(1) ? 1 : is_zero(2) ? 2 : 3, U.col(0), U.col(1)};
}

/// Writes b = mu_c n_c.N0 and J = I - mu_c n_c.W for given directions n [3][m].
void project(const SlidingContacts& contacts, const Matrix3Xd& n, VectorXd* b, MatrixXd* J) {
  const auto m = static_cast<Eigen::Index>(contacts.size());
  for (Eigen::Index c = 0; c < m; ++c) {
    const double mu = contacts.mu[static_cast<std::size_t>(c)];
    (*b)(c) = mu * n.col(c).dot(contacts.N0.col(c));
    for (Eigen::Index j = 0; j < m; ++j)
      (*J)(c, j) = (c == j ? 1.0 : 0.0) - mu * n.col(c).dot(contacts.W[static_cast<std::size_t>(j)].col(c));
  }
}

VectorXd defect(const SlidingContacts& contacts, const VectorXd& s, Matrix3Xd* normal) {
  *normal = contacts.N0;
  for (Eigen::Index j = 0; j < s.size(); ++j) *normal += s(j) * contacts.W[static_cast<std::size_t>(j)];
  VectorXd result(s.size());
  for (Eigen::Index c = 0; c < s.size(); ++c)
    result(c) = contacts.mu[static_cast<std::size_t>(c)] * normal->col(c).norm() - s(c);
  return result;
}

void add_new(const VectorXd& s, std::vector<VectorXd>* found) {
  const double scale = s.lpNorm<Eigen::Infinity>();
  for (const VectorXd& known : *found) {
    const double size = std::max(scale, known.lpNorm<Eigen::Infinity>());
    if ((known - s).lpNorm<Eigen::Infinity>() <= 1e-8 * size) return;
  }
  found->push_back(s);
}

/// Calls visit(n) for each choice of one corner for each contact.
template <class Visit>
void for_each_choice(const std::vector<std::vector<Vector3d>>& corners, const Visit& visit) {
  const std::size_t m = corners.size();
  std::vector<std::size_t> choice(m, 0);
  Matrix3Xd n(3, static_cast<Eigen::Index>(m));
  for (;;) {
    for (std::size_t c = 0; c < m; ++c) n.col(static_cast<Eigen::Index>(c)) = corners[c][choice[c]];
    visit(n);
    std::size_t c = 0;
    while (c < m && ++choice[c] == corners[c].size()) choice[c++] = 0;
    if (c == m) return;
  }
}

/// Solves s = mu |N0 + W s|, that is (1 - mu^2 |W|^2) s^2 - 2 mu^2 (N0.W) s - mu^2 |N0|^2 = 0, s >= 0.
void solve_quadratic(const SlidingContacts& contacts, SlidingSolutions* result) {
  const double mu2 = contacts.mu[0] * contacts.mu[0];
  const Vector3d N0 = contacts.N0.col(0), W = contacts.W[0].col(0);
  const double a = 1.0 - mu2 * W.squaredNorm(), b = -mu2 * N0.dot(W), c = -mu2 * N0.squaredNorm();
  const double discriminant = b * b - a * c;
  const auto add = [&](double s) {
    if (std::isfinite(s) && s >= 0.0) add_new(VectorXd::Constant(1, s), &result->found);
  };
  if (discriminant >= 0.0) {
    const double q = -(b + std::copysign(std::sqrt(discriminant), b));
    if (a != 0.0) add(q / a);
    if (q != 0.0) add(c / q);
    if (q == 0.0) add(0.0);
  }
  result->determinant_changes = a <= 0.0;
  result->is_complete = true;
}

void decide(SlidingSolutions* result) {
  const std::size_t count = result->found.size();
  if (count > 1) {
    result->uniqueness = Uniqueness::Several;
  } else if (result->is_complete) {
    result->uniqueness = count == 1 ? Uniqueness::Proven : Uniqueness::None;
  }
}

/// Directions of normal forces to try, as corners.
struct Corners {
  std::vector<std::vector<Vector3d>> of_contact;  // both directions of a line, or an octagon around a circle
  bool are_in_planes = true, all_on_lines = true;
  std::size_t num_choices = 1;
};

Corners list_corners(const SlidingContacts& contacts) {
  constexpr int num_corners = 8;
  Corners corners;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Directions directions = find_directions(contacts, static_cast<Eigen::Index>(c));
    corners.are_in_planes = corners.are_in_planes && directions.dimension < 3;
    corners.all_on_lines = corners.all_on_lines && directions.dimension == 1;
    if (!corners.are_in_planes) break;
    std::vector<Vector3d>& own = corners.of_contact.emplace_back();
    if (directions.dimension == 1) own = {directions.first, -directions.first};
    for (int k = 0; directions.dimension == 2 && k < num_corners; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / num_corners;
      own.push_back((std::cos(angle) * directions.first + std::sin(angle) * directions.second) /
                    std::cos(std::numbers::pi / num_corners));
    }
    corners.num_choices *= own.size();
  }
  return corners;
}

/// Starts from the solution of one choice of corners; on circles Newton's method continues from there. Adds the result
/// if it obeys the law.
void follow_choice(const SlidingContacts& contacts, const dense::Lu& lu, bool is_exact, VectorXd* b, MatrixXd* J,
                   std::vector<VectorXd>* found) {
  Matrix3Xd normal;
  VectorXd s = lu.solve(*b);
  for (int pass = 0; !is_exact && pass < 20; ++pass) {
    const VectorXd rest = defect(contacts, s, &normal);
    if (rest.lpNorm<Eigen::Infinity>() <= 1e-13 * s.lpNorm<Eigen::Infinity>()) break;
    for (Eigen::Index c = 0; c < s.size(); ++c) normal.col(c).normalize();
    project(contacts, normal, b, J);
    s = dense::solve(*J, *b);
  }
  const double size = s.lpNorm<Eigen::Infinity>();
  const bool is_solution = std::isfinite(size) && s.minCoeff() >= -1e-12 * size &&
                           defect(contacts, s, &normal).lpNorm<Eigen::Infinity>() <= 1e-9 * size;
  if (is_solution || size == 0.0) add_new(s, found);
}

/// Tries all choices of corners. On lines each choice has one candidate. On circles one sign of all determinants proves
/// uniqueness; if there are both signs, boxes are searched.
void try_corners(const SlidingContacts& contacts, const Corners& corners, std::size_t most_boxes,
                 SlidingSolutions* result) {
  const auto m = static_cast<Eigen::Index>(contacts.size());
  VectorXd b(m);
  MatrixXd J(m, m);
  bool is_positive = false, is_negative = false;
  for_each_choice(corners.of_contact, [&](const Matrix3Xd& n) {
    project(contacts, n, &b, &J);
    const dense::Lu lu(J);
    const double determinant = lu.determinant();
    is_positive = is_positive || determinant > 0.0;
    is_negative = is_negative || determinant < 0.0;
    if (determinant != 0.0) follow_choice(contacts, lu, corners.all_on_lines, &b, &J, &result->found);
  });
  result->determinant_changes = is_positive && is_negative;
  result->is_complete = corners.all_on_lines;
  const bool has_one_sign = !result->determinant_changes && (is_positive || is_negative);
  if (has_one_sign) result->uniqueness = Uniqueness::Proven;
  if (!corners.all_on_lines && (!has_one_sign || result->found.empty())) {
    std::vector<VectorXd> by_boxes;
    result->is_complete = find_sizes_by_boxes(contacts, most_boxes, &by_boxes);
    for (const VectorXd& s : by_boxes) add_new(s, &result->found);
  }
  if (!has_one_sign) decide(result);
}

}  // namespace

SlidingSolutions find_sliding(const SlidingContacts& contacts, std::size_t most_boxes) {
  constexpr std::size_t most_choices = 4096;
  SlidingSolutions result;
  result.amplification = ContractionBound().amplification(contacts);
  if (!std::isnan(result.amplification)) {
    result.uniqueness = Uniqueness::Proven;
    return result;
  }
  if (contacts.size() > most_enumerated) return result;
  const Corners corners = list_corners(contacts);
  const bool is_one_circle = corners.are_in_planes && contacts.size() == 1 && !corners.all_on_lines;
  if (is_one_circle) {
    solve_quadratic(contacts, &result);
    decide(&result);
  } else if (!corners.are_in_planes || corners.num_choices > most_choices) {
    result.is_complete = find_sizes_by_boxes(contacts, most_boxes, &result.found);
    decide(&result);
  } else {
    try_corners(contacts, corners, most_boxes, &result);
  }
  return result;
}

void add_by_iteration(const SlidingContacts& contacts, std::vector<VectorXd>* found) {
  constexpr int most_iterations = 10000;
  constexpr double rounding = 1e-14;  // below this the last digits may cycle
  VectorXd s = VectorXd::Zero(static_cast<Eigen::Index>(contacts.size()));
  Matrix3Xd normal;
  for (int k = 0; k < most_iterations; ++k) {
    const VectorXd rest = defect(contacts, s, &normal);
    s += rest;
    if (!(rest.lpNorm<Eigen::Infinity>() > rounding * s.lpNorm<Eigen::Infinity>())) {
      if (s.allFinite()) found->push_back(s);
      return;
    }
  }
}

}  // namespace tanor::detail
