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
std::optional<Matrix3Xd> find_lines(const ContactProblem& problem) {
  constexpr double rounding = 1e-11;
  const Eigen::Index m = problem.size();
  Matrix3Xd lines = Matrix3Xd::Zero(3, m), all(3, m + 1);
  for (Eigen::Index c = 0; c < m; ++c) {
    all << problem.N0.segment<3>(3 * c), problem.W.middleRows<3>(3 * c);
    for (Eigen::Index k = m; k >= 0; --k) {
      all.col(k).normalize();  // 0 stays
      if (!all.col(k).isZero(0.0)) lines.col(c) = all.col(k);
    }
    const auto line = lines.col(c);
    if ((all - line * (line.transpose() * all)).norm() > rounding * all.norm()) return std::nullopt;
  }
  return lines;
}

/// Tries all signs sigma of the normal forces, N_c along sigma_c n_c: (I - sigma mu n.W) s = sigma mu n.N0 has one
/// solution each, which obeys the law if no s is negative. One sign of all determinants proves uniqueness.
void try_signs(const ContactProblem& problem, const Matrix3Xd& lines, SlidingSolutions* result) {
  const Eigen::Index m = problem.size();
  VectorXd b(m), sigma(m);
  MatrixXd R(m, m);
  for (Eigen::Index c = 0; c < m; ++c) {
    const Eigen::Vector3d along = problem.contacts[static_cast<std::size_t>(c)].mu * lines.col(c);
    b(c) = along.dot(problem.N0.segment<3>(3 * c));
    R.row(c) = along.transpose() * problem.W.middleRows<3>(3 * c);
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
    double missed = 0.0;
    for (std::size_t c = 0; c < problem.contacts.size(); ++c)
      missed = std::max(missed, std::abs(problem.limit(c, s) - s(static_cast<Eigen::Index>(c))));
    if (std::isfinite(size) && s.minCoeff() >= -1e-12 * size && missed <= 1e-9 * size) add_new(s, &result->found);
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

SlidingSolutions find_sliding(const ContactProblem& problem) {
  SlidingSolutions result;
  result.amplification = ContractionBound().amplification(problem);
  if (!std::isnan(result.amplification)) result.uniqueness = Uniqueness::Proven;
  if (result.uniqueness == Uniqueness::Proven || problem.contacts.size() > most_enumerated) return result;
  if (const std::optional<Matrix3Xd> lines = find_lines(problem))
    try_signs(problem, *lines, &result);
  else
    result.is_complete = find_sizes_by_boxes(problem, &result.found);
  if (result.uniqueness == Uniqueness::Proven) return result;
  const std::size_t count = result.found.size();
  if (count > 1 || result.is_complete)
    result.uniqueness = count > 1 ? Uniqueness::Several : count == 1 ? Uniqueness::Proven : Uniqueness::None;
  return result;
}

}  // namespace tanor::detail
