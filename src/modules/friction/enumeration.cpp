#include "friction/enumeration.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/dense.hpp"
#include "friction/contraction.hpp"

namespace tanor::detail {

namespace {

using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns the line of each normal force, as unit vectors [3][m], or nothing if some force leaves its line.
std::optional<Matrix3Xd> find_lines(const SlidingContacts& contacts) {
  constexpr double rounding = 1e-11;
  const auto m = static_cast<Eigen::Index>(contacts.size());
  Matrix3Xd lines = Matrix3Xd::Zero(3, m), all(3, m + 1);
  for (Eigen::Index c = 0; c < m; ++c) {
    all.col(0) = contacts.N0.col(c);
    for (Eigen::Index j = 0; j < m; ++j) all.col(j + 1) = contacts.W[static_cast<std::size_t>(j)].col(c);
    for (Eigen::Index k = m; k >= 0; --k) {
      all.col(k).normalize();  // 0 stays
      if (!all.col(k).isZero(0.0)) lines.col(c) = all.col(k);
    }
    const auto line = lines.col(c);
    if ((all - line * (line.transpose() * all)).norm() > rounding * all.norm()) return std::nullopt;
  }
  return lines;
}

VectorXd defect(const SlidingContacts& contacts, const VectorXd& s) {
  Matrix3Xd normal = contacts.N0;
  for (Eigen::Index j = 0; j < s.size(); ++j) normal += s(j) * contacts.W[static_cast<std::size_t>(j)];
  const Eigen::Map<const VectorXd> mu(contacts.mu.data(), s.size());
  return mu.cwiseProduct(normal.colwise().norm().transpose()) - s;
}

/// Tries all signs sigma of the normal forces, N_c along sigma_c n_c: (I - sigma mu n.W) s = sigma mu n.N0 has one
/// solution each, which obeys the law if no s is negative. One sign of all determinants proves uniqueness.
void try_signs(const SlidingContacts& contacts, const Matrix3Xd& lines, SlidingSolutions* result) {
  const auto m = static_cast<Eigen::Index>(contacts.size());
  VectorXd b(m), sigma(m);
  MatrixXd R(m, m);
  for (Eigen::Index c = 0; c < m; ++c) {
    const double mu = contacts.mu[static_cast<std::size_t>(c)];
    b(c) = mu * lines.col(c).dot(contacts.N0.col(c));
    for (Eigen::Index j = 0; j < m; ++j)
      R(c, j) = mu * lines.col(c).dot(contacts.W[static_cast<std::size_t>(j)].col(c));
  }
  bool is_positive = false, is_negative = false;
  for (std::size_t signs = 0; signs < std::size_t{1} << m; ++signs) {
    for (Eigen::Index c = 0; c < m; ++c) sigma(c) = (signs >> c) & 1 ? -1.0 : 1.0;
    const dense::Lu lu(MatrixXd::Identity(m, m) - sigma.asDiagonal() * R);
    const double determinant = lu.determinant();
    is_positive = is_positive || determinant > 0.0;
    is_negative = is_negative || determinant < 0.0;
    if (determinant == 0.0) continue;
    const VectorXd s = lu.solve(sigma.cwiseProduct(b));
    const double size = s.lpNorm<Eigen::Infinity>();
    const bool is_solution = std::isfinite(size) && s.minCoeff() >= -1e-12 * size &&
                             defect(contacts, s).lpNorm<Eigen::Infinity>() <= 1e-9 * size;
    if (is_solution) add_new(s, &result->found);
  }
  result->is_complete = true;
  result->determinant_changes = is_positive && is_negative;
  if (is_positive != is_negative) result->uniqueness = Uniqueness::Proven;
}

}  // namespace

void add_new(const VectorXd& s, std::vector<VectorXd>* found) {
  const double scale = s.lpNorm<Eigen::Infinity>();
  const auto is_same = [&](const VectorXd& known) {
    return (known - s).lpNorm<Eigen::Infinity>() <= 1e-8 * std::max(scale, known.lpNorm<Eigen::Infinity>());
  };
  if (std::ranges::none_of(*found, is_same)) found->push_back(s);
}

SlidingSolutions find_sliding(const SlidingContacts& contacts) {
  SlidingSolutions result;
  result.amplification = ContractionBound().amplification(contacts);
  if (!std::isnan(result.amplification)) result.uniqueness = Uniqueness::Proven;
  if (result.uniqueness == Uniqueness::Proven || contacts.size() > most_enumerated) return result;
  if (const std::optional<Matrix3Xd> lines = find_lines(contacts))
    try_signs(contacts, *lines, &result);
  else
    result.is_complete = find_sizes_by_boxes(contacts, &result.found);
  if (result.uniqueness == Uniqueness::Proven) return result;
  const std::size_t count = result.found.size();
  if (count > 1 || result.is_complete)
    result.uniqueness = count > 1 ? Uniqueness::Several : count == 1 ? Uniqueness::Proven : Uniqueness::None;
  return result;
}

void add_by_iteration(const SlidingContacts& contacts, std::vector<VectorXd>* found) {
  constexpr int most_iterations = 10000;
  constexpr double rounding = 1e-14;  // below this the last digits may cycle
  VectorXd s = VectorXd::Zero(static_cast<Eigen::Index>(contacts.size()));
  for (int k = 0; k < most_iterations; ++k) {
    const VectorXd rest = defect(contacts, s);
    s += rest;
    if (!(rest.lpNorm<Eigen::Infinity>() > rounding * s.lpNorm<Eigen::Infinity>())) {
      if (s.allFinite()) found->push_back(s);
      return;
    }
  }
}

}  // namespace tanor::detail
