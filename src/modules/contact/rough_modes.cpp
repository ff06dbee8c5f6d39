#include "contact/rough_modes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "base/dense.hpp"
#include "friction/contact_problem.hpp"
#include "friction/range.hpp"

namespace tanor::detail {

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double rank_rounding = 1e-11;

/// The closed contacts of one set: the forces r = r0 + R x, where x is the friction of their ContactProblem.
class ClosedSet {
 public:
  ClosedSet(const RoughProblem& problem, const VectorXd& velocities, const std::vector<double>& rest, unsigned set);

  /// Returns false if nothing keeps all of these normals closed.
  bool is_possible() const { return is_possible_; }
  bool has_unique_normals() const { return has_unique_normals_; }
  const ContactProblem& problem() const { return problem_; }
  VectorXd forces(const VectorXd& x) const { return r0_ + R_ * x; }

 private:
  ContactProblem problem_;
  VectorXd r0_;
  MatrixXd R_;
  bool is_possible_ = true, has_unique_normals_ = true;
};

ClosedSet::ClosedSet(const RoughProblem& rough, const VectorXd& velocities, const std::vector<double>& rest,
                     unsigned set) {
  const MatrixXd& W = rough.W;
  std::vector<Eigen::Index> normals;
  MatrixXd B = MatrixXd::Zero(W.rows(), 3 * static_cast<Eigen::Index>(rough.size()));  // friction x as components of r
  Eigen::Index k = 0;
  for (std::size_t c = 0; c < rough.size(); ++c) {
    if ((set >> c & 1u) == 0) continue;
    const Eigen::Index first = 3 * static_cast<Eigen::Index>(c);
    const RoughContact& contact = rough.contacts[c];
    const Eigen::Vector2d u = rough.tangential(c, velocities);
    // Friction where nothing lets the point move is a share of the load, and is left out.
    const Range along(W.block<2, 2>(first + 1, first + 1), rank_rounding, W.diagonal().maxCoeff());
    const bool moves = !contact.has_friction() || u.norm() > rest[c] || along.vectors.cols() == 0;
    const Eigen::Index dimension = moves ? 1 : along.vectors.cols();
    normals.push_back(first);
    problem_.contacts.push_back({k, dimension, moves, contact.mu});
    problem_.outward.emplace_back(1.0, 0.0, 0.0);
    if (!moves)
      B.block(first + 1, k, 2, dimension) = along.vectors;
    else if (contact.has_friction() && u.norm() > rest[c])
      B.block<2, 1>(first + 1, k) = -u / u.norm();
    k += dimension;
  }
  B.conservativeResize(Eigen::NoChange, k);
  const auto m = static_cast<Eigen::Index>(normals.size());
  // r_n = -W_nn^-1 (q_n + W_nt B x)
  const MatrixXd W_nt = W(normals, Eigen::all) * B;
  const VectorXd q_n = rough.q(normals);
  const Range range(W(normals, normals), rank_rounding, W.diagonal().maxCoeff());
  const MatrixXd inverse = range.vectors * range.values.cwiseInverse().asDiagonal() * range.vectors.transpose();
  has_unique_normals_ = range.is_whole();
  if (!has_unique_normals_) {
    const double scale = std::max(rough.q.lpNorm<Eigen::Infinity>(), std::numeric_limits<double>::min());
    is_possible_ = (range.null.transpose() * q_n).lpNorm<Eigen::Infinity>() <= 1e-9 * scale;
  }
  r0_ = VectorXd::Zero(W.rows());
  r0_(normals) = -inverse * q_n;
  R_ = B;
  R_(normals, Eigen::all) = -inverse * W_nt;
  problem_.A = B.transpose() * W * R_;
  problem_.A = (0.5 * (problem_.A + problem_.A.transpose())).eval();
  problem_.a0 = B.transpose() * (rough.q + W * r0_);
  problem_.N0 = VectorXd::Zero(3 * m);
  problem_.W = MatrixXd::Zero(3 * m, k);
  for (Eigen::Index c = 0; c < m; ++c) {
    problem_.N0(3 * c) = r0_(normals[static_cast<std::size_t>(c)]);
    problem_.W.row(3 * c) = R_.row(normals[static_cast<std::size_t>(c)]);
  }
  // The rounding of what others hold would move points under large forces.
  constexpr double rounding = 1e-12;
  const double mobility = W.diagonal().maxCoeff();
  const double scale = std::max(rough.q.lpNorm<Eigen::Infinity>(), (W * r0_).lpNorm<Eigen::Infinity>());
  for (Eigen::Index i = 0; i < k; ++i) {
    if (std::abs(problem_.a0(i)) <= rounding * scale) problem_.a0(i) = 0.0;
    if (problem_.A(i, i) > rounding * mobility) continue;
    problem_.A.row(i).setZero();
    problem_.A.col(i).setZero();
  }
}

/// Returns true if there is one motion, whichever it is: friction changes no normal force and these are unique, or
/// there is one contact whose friction cannot take more than its normal force gives, W_nn > mu |W_nt|.
bool has_one_motion(const RoughProblem& problem) {
  double coupling = 0.0;
  for (std::size_t c = 0; c < problem.size(); ++c) {
    const Eigen::Index i = 3 * static_cast<Eigen::Index>(c);
    for (Eigen::Index other = 0; other < problem.W.rows(); other += 3)
      coupling = std::max(coupling, problem.contacts[c].mu * problem.W.block<2, 1>(i + 1, other).norm());
  }
  const double mobility = problem.W.diagonal().maxCoeff();
  const auto normals = Eigen::seqN(0, static_cast<Eigen::Index>(problem.size()), 3);
  if (coupling <= rank_rounding * mobility)
    return Range(problem.W(normals, normals), rank_rounding, mobility).is_whole();
  return problem.size() == 1 && problem.W(0, 0) > (1.0 + 1e-9) * coupling;
}

/// Returns all sets of contacts, those with most of them first.
std::vector<unsigned> list_sets(std::size_t contacts) {
  std::vector<unsigned> sets(std::size_t{1} << contacts);
  std::iota(sets.rbegin(), sets.rend(), 0u);
  std::ranges::stable_sort(sets, std::ranges::greater{}, [](unsigned set) { return std::popcount(set); });
  return sets;
}

}  // namespace

RoughMotions find_motions(const RoughProblem& problem, const VectorXd& velocities, const std::vector<double>& rest,
                          std::size_t work_left, bool is_start) {
  constexpr double rounding = 1e-10, same = 1e-8;
  const MatrixXd& W = problem.W;
  RoughMotions result;
  if (problem.size() > most_contacts_counted) {
    result.reason = "modes of more than ten contacts are too many to try";
    return result;
  }
  const auto scale_of = [&](const VectorXd& r) {
    return std::max(problem.q.lpNorm<Eigen::Infinity>(), (W * r).lpNorm<Eigen::Infinity>());
  };
  const auto add = [&](RoughMotion motion) {
    const VectorXd u = problem.q + W * motion.r;
    const double scale = scale_of(motion.r);
    for (std::size_t c = 0; c < problem.size(); ++c)
      if (motion.is_closed[c] == 0 && problem.normal(c, u) < -rounding * scale) return;
    for (const RoughMotion& other : result.found)
      if ((W * (motion.r - other.r)).lpNorm<Eigen::Infinity>() <= same * std::max(scale, scale_of(other.r))) return;
    result.found.push_back(std::move(motion));
  };
  const bool is_one = has_one_motion(problem);
  const auto nothing_closed = std::vector<char>(problem.size(), 0);
  for (const unsigned set : list_sets(problem.size())) {
    if (is_one && !result.found.empty()) break;
    if (set == 0) {
      add({nothing_closed, VectorXd::Zero(problem.q.size())});
      continue;
    }
    if (work_left == 0) {
      result.reason = "modes of open, stick and slip are too many to try";
      if (!result.found.empty()) break;
    }
    const ClosedSet closed(problem, velocities, rest, set);
    if (!closed.is_possible()) continue;
    const VectorXd nothing = VectorXd::Zero(closed.problem().size());
    ContactSolutions solutions;
    if (work_left > 0) {
      solutions = find_all(closed.problem(), &work_left, nothing, is_start ? 16 : 0);
    } else if (const VectorXd x = find_one(closed.problem(), nothing); x.size() > 0 && !closed.problem().pulls(x)) {
      solutions.found.push_back(x);
    }
    for (const VectorXd& x : solutions.found) {
      RoughMotion motion{nothing_closed, closed.forces(x)};
      for (std::size_t c = 0; c < problem.size(); ++c) motion.is_closed[c] = set >> c & 1u;
      add(std::move(motion));
    }
    if (is_one) continue;
    if (!solutions.is_complete && result.reason.empty()) result.reason = solutions.reason;
    if (!closed.has_unique_normals() && result.reason.empty())
      result.reason = "contacts press on each other in many ways, and friction depends on how";
  }
  result.uniqueness = result.found.size() > 1  ? Uniqueness::Several
                      : !result.reason.empty() ? Uniqueness::Unproven
                      : result.found.empty()   ? Uniqueness::None
                                               : Uniqueness::Proven;
  return result;
}

}  // namespace tanor::detail
