#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>

#include "friction/contact_problem.hpp"
#include "friction/enumeration.hpp"

/// \file All motions of a ContactProblem: mode by mode, stick and slip each way.
namespace tanor {

namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Of a contact; the sign is that of its friction.
enum Mode : int { sticks = 0, forward = 1, backward = -1 };

/// Calls visit(modes) for all modes of contacts at rest, those that move keep `forward`.
template <class Visit>
void for_all_modes(const ContactProblem& problem, bool moving_have_two, const Visit& visit) {
  std::vector<int> modes;
  for (const auto& contact : problem.contacts) modes.push_back(contact.moves ? forward : sticks);
  for (;;) {
    visit(modes);
    std::size_t c = 0;
    for (; c < modes.size(); ++c) {
      const bool moves = problem.contacts[c].moves;
      if (moves && !moving_have_two) continue;
      if (modes[c] == backward) {
        modes[c] = moves ? forward : sticks;
        continue;
      }
      modes[c] = modes[c] == sticks ? forward : backward;
      break;
    }
    if (c == modes.size()) return;
  }
}

/// The lines that normal forces keep to, [3 contacts]; none where one leaves its line.
std::optional<VectorXd> find_normals(const ContactProblem& problem) {
  const auto m = static_cast<Eigen::Index>(problem.contacts.size());
  VectorXd normals(3 * m);
  for (Eigen::Index c = 0; c < m; ++c) {
    MatrixXd all(3, problem.size() + 1);
    all << problem.N0.segment<3>(3 * c), problem.W.middleRows<3>(3 * c);
    const double unit = all.col(0).norm();
    if (unit > 0.0) all.col(0) /= unit;
    const Eigen::JacobiSVD<MatrixXd> svd(all, Eigen::ComputeFullU);
    const auto& sigma = svd.singularValues();
    constexpr double rounding = 1e-11;
    if (sigma.size() > 1 && problem.contacts[static_cast<std::size_t>(c)].mu * sigma(1) > rounding * std::max(1.0, sigma(0)))
      return {};
    normals.segment<3>(3 * c) = svd.matrixU().col(0);
  }
  return normals;
}

class Counting {
 public:
  explicit Counting(const ContactProblem& problem) : problem_(problem), A_(problem.A.lpNorm<Eigen::Infinity>()) {}

  void add(const VectorXd& x) {
    if (!x.allFinite() || !(problem_.residual(x) <= obeys_below)) return;
    const auto same = [&](const VectorXd& other) { return problem_.are_same(x, other); };
    if (std::none_of(found_.begin(), found_.end(), same)) found_.push_back(x);
  }
  void try_linear_mode(const std::vector<int>& modes, const VectorXd& normals);
  void try_mode(const std::vector<int>& modes);
  void try_shares();

  ContactSolutions take(const char* what_was_tried) {
    ContactSolutions result;
    result.uniqueness = found_.size() > 1   ? Uniqueness::Several
                        : !reason_.empty()  ? Uniqueness::Unproven
                        : found_.size() == 1 ? Uniqueness::Proven
                                             : Uniqueness::None;
    result.found = std::move(found_);
    if (result.uniqueness == Uniqueness::Unproven) result.reason = reason_ + what_was_tried;
    return result;
  }

 private:
  const ContactProblem& problem_;
  const double A_;  // size of A
  std::vector<VectorXd> found_;
  std::string reason_;
};

/// Where N_c = n_c (n_c.N_c): slip with x_c = +-mu n_c.N_c, whichever sense and sign of N that means.
void Counting::try_linear_mode(const std::vector<int>& modes, const VectorXd& normals) {
  const Eigen::Index k = problem_.size();
  MatrixXd J(k, k);
  VectorXd right(k);
  for (std::size_t c = 0; c < modes.size(); ++c) {
    const Eigen::Index row = problem_.contacts[c].first, at = 3 * static_cast<Eigen::Index>(c);
    if (modes[c] == sticks) {
      J.row(row) = problem_.A.row(row) / A_;
      right(row) = -problem_.a0(row) / A_;
      continue;
    }
    const double factor = modes[c] * problem_.contacts[c].mu;
    const auto n = normals.segment<3>(at);
    J.row(row) = -factor * n.transpose() * problem_.W.middleRows<3>(at);
    J(row, row) += 1.0;
    right(row) = factor * n.dot(problem_.N0.segment<3>(at));
  }
  const Eigen::PartialPivLU<MatrixXd> lu(J);
  // Where contacts that stick share a load, the ends of what they can share are solutions of other modes.
  if (std::abs(lu.determinant()) <= 1e-13 * J.rowwise().norm().prod()) return;
  add(lu.solve(right));
}

/// What sticks eliminated, the sizes of friction where it slips are an absolute value equation.
void Counting::try_mode(const std::vector<int>& modes) {
  std::vector<Eigen::Index> stick, slip;
  std::vector<std::size_t> slipping;
  for (std::size_t c = 0; c < modes.size(); ++c) {
    const Eigen::Index row = problem_.contacts[c].first;
    modes[c] == sticks ? stick.push_back(row) : slip.push_back(row);
    if (modes[c] != sticks) slipping.push_back(c);
  }
  if (slip.empty() && stick.empty()) return;
  // x_S = p + Q s
  const auto q = static_cast<Eigen::Index>(slip.size());
  MatrixXd signs = MatrixXd::Zero(problem_.size(), q);
  for (Eigen::Index j = 0; j < q; ++j)
    signs(slip[static_cast<std::size_t>(j)], j) = modes[slipping[static_cast<std::size_t>(j)]];
  VectorXd p = VectorXd::Zero(problem_.size());
  MatrixXd Q = signs;
  if (!stick.empty()) {
    const MatrixXd A_SS = problem_.A(stick, stick);
    const Eigen::PartialPivLU<MatrixXd> lu(A_SS);
    if (!(std::abs(lu.determinant()) > 1e-13 * A_SS.rowwise().norm().prod())) return;  // as above
    const VectorXd a0_S = problem_.a0(stick);
    const MatrixXd A_S = problem_.A(stick, Eigen::all) * signs;
    p(stick) = -lu.solve(a0_S);
    Q(stick, Eigen::all) = -lu.solve(A_S);
  }
  if (q == 0) return add(p);
  SlidingContacts contacts;
  contacts.N0.resize(3, q);
  contacts.W.assign(static_cast<std::size_t>(q), Eigen::Matrix3Xd(3, q));
  for (Eigen::Index j = 0; j < q; ++j) {
    const std::size_t c = slipping[static_cast<std::size_t>(j)];
    const auto W = problem_.W.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    contacts.mu.push_back(problem_.contacts[c].mu);
    contacts.N0.col(j) = problem_.N0.segment<3>(3 * static_cast<Eigen::Index>(c)) + W * p;
    for (Eigen::Index i = 0; i < q; ++i) contacts.W[static_cast<std::size_t>(i)].col(j) = W * Q.col(i);
  }
  SlidingSolutions solutions = find_sliding(contacts, many_boxes);
  if (solutions.found.empty() && solutions.uniqueness == Uniqueness::Proven)
    add_by_iteration(contacts, &solutions.found);
  const bool is_all = solutions.is_complete || (solutions.uniqueness == Uniqueness::Proven && !solutions.found.empty());
  if (!is_all) reason_ = "the reactions of contacts that slide could not be searched to the end";
  for (const VectorXd& s : solutions.found) add(p + Q * s);
}

/// All stick and share the load in many ways: any of them that obeys the law makes rest a solution. The sets of shares
/// end where contacts reach their limits, which other modes find; but not each such set has a corner.
void Counting::try_shares() {
  for (const auto& contact : problem_.contacts) {
    if (contact.moves) return;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(problem_.A);
  const Eigen::Index dimension = (eigen.eigenvalues().array() <= 1e-12 * eigen.eigenvalues().maxCoeff()).count();
  if (dimension == 0) return;
  VectorXd x = -problem_.A.completeOrthogonalDecomposition().solve(problem_.a0);
  const VectorXd rest = problem_.accelerations(x);
  if (!(rest.lpNorm<Eigen::Infinity>() <= 1e-9 * problem_.acceleration_scale(x))) return;
  const MatrixXd free = eigen.eigenvectors().leftCols(dimension);
  const auto excess = [&](const VectorXd& at) {
    double worst = -std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < problem_.contacts.size(); ++c)
      worst = std::max(worst, std::abs(at(problem_.contacts[c].first)) -
                                  problem_.contacts[c].mu * problem_.normal_force(c, at).norm());
    return worst;
  };
  // Along lines: x_c^2 <= mu^2 |N_c|^2 begins and ends at roots of quadratics, the rest lies between them.
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  const int lines = dimension == 1 ? 1 : 200;
  for (int line = 0; line < lines && excess(x) > 0.0; ++line) {
    VectorXd weights(dimension);
    for (Eigen::Index i = 0; i < dimension; ++i) weights(i) = dimension == 1 ? 1.0 : normal(random);
    const VectorXd d = free * weights.normalized();
    std::vector<double> roots{0.0};
    for (std::size_t c = 0; c < problem_.contacts.size(); ++c) {
      const double mu = problem_.contacts[c].mu;
      const Eigen::Index row = problem_.contacts[c].first;
      const Vector3d N = problem_.normal_force(c, x), dN = problem_.W.middleRows<3>(3 * static_cast<Eigen::Index>(c)) * d;
      const double a = d(row) * d(row) - mu * mu * dN.squaredNorm(), b = x(row) * d(row) - mu * mu * N.dot(dN);
      const double e = x(row) * x(row) - mu * mu * N.squaredNorm(), discriminant = b * b - a * e;
      if (discriminant < 0.0) continue;
      const double root = -(b + std::copysign(std::sqrt(discriminant), b));
      if (a != 0.0) roots.push_back(root / a);
      if (root != 0.0) roots.push_back(e / root);
    }
    std::sort(roots.begin(), roots.end());
    const double wide = 1.0 + std::max(std::abs(roots.front()), std::abs(roots.back()));
    std::vector<double> steps{roots.front() - wide, roots.back() + wide};
    for (std::size_t i = 0; i + 1 < roots.size(); ++i) steps.push_back(0.5 * (roots[i] + roots[i + 1]));
    VectorXd best = x;
    for (const double s : steps) {
      if (excess(x + s * d) < excess(best)) best = x + s * d;
    }
    x = best;
  }
  add(x);
  if (dimension > 1 && found_.size() < 2 && excess(x) > 0.0 && problem_.W.cwiseAbs().maxCoeff() > 1e-11)
    reason_ = "contacts that stick may share the load in more ways than were tried";
}

// ---- contacts on surfaces ----

/// One contact at rest on a surface that slides to d = (cos, sin): x = -h d, h = +-mu n.(N0 + W x), a0 + A x along d.
void try_directions(const ContactProblem& problem, Counting* counting) {
  const Eigen::Matrix2d A = problem.A;
  const Eigen::Vector2d a0 = problem.a0;
  const double mu = problem.contacts[0].mu;
  const auto normals = find_normals(problem);
  if (!normals) return;
  const Vector3d n = *normals;
  const Eigen::RowVector2d w = n.transpose() * problem.W;
  const double N0 = n.dot(problem.N0);
  constexpr int samples = 1440;
  for (const double sign : {1.0, -1.0}) {
    const auto friction = [&](double angle) -> Eigen::Vector2d {
      const Eigen::Vector2d d(std::cos(angle), std::sin(angle));
      return -sign * mu * N0 / (1.0 + sign * mu * w.dot(d)) * d;
    };
    const auto across = [&](double angle) {
      const Eigen::Vector2d a = a0 + A * friction(angle);
      // without the denominator, so that it has no poles
      return (std::cos(angle) * a(1) - std::sin(angle) * a(0)) *
             (1.0 + sign * mu * (w(0) * std::cos(angle) + w(1) * std::sin(angle)));
    };
    double low = 0.0, at_low = across(low);
    for (int k = 1; k <= samples; ++k) {
      double high = 2.0 * std::numbers::pi * k / samples;
      const double end = high, at_end = across(end);
      if (at_low == 0.0 || (at_low > 0.0) != (at_end > 0.0)) {
        double left = low;
        for (int pass = 0; pass < 60; ++pass) {
          const double middle = 0.5 * (left + high);
          ((across(middle) > 0.0) == (at_low > 0.0) ? left : high) = middle;
        }
        counting->add(friction(0.5 * (left + high)));
      }
      low = end;
      at_low = at_end;
    }
  }
}

ContactSolutions try_starts(const ContactProblem& problem, const VectorXd& guess) {
  Counting counting(problem);
  const bool is_alone = problem.contacts.size() == 1;
  const VectorXd rest = -problem.A.completeOrthogonalDecomposition().solve(problem.a0);
  counting.add(rest);
  if (is_alone) {
    try_directions(problem, &counting);
    return counting.take("");
  }
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  constexpr int starts = 16;
  for (int k = 0; k < starts + 2; ++k) {
    VectorXd x = k == 0 ? guess : rest;
    for (Eigen::Index i = 0; k > 1 && i < x.size(); ++i) x(i) = normal(random) * (1.0 + rest.lpNorm<Eigen::Infinity>());
    if (x.size() == problem.size()) {
      const VectorXd found = find_one(problem, x);
      if (found.size() > 0) counting.add(found);
    }
  }
  ContactSolutions result = counting.take("");
  if (result.uniqueness != Uniqueness::Several) {
    result.uniqueness = Uniqueness::Unproven;
    result.reason = "on surfaces not every direction of sliding can be tried";
  }
  return result;
}

ContactSolutions found_one(const ContactProblem& problem, Uniqueness uniqueness, const VectorXd& guess,
                           std::string reason) {
  ContactSolutions result{uniqueness, {}, std::move(reason)};
  const VectorXd x = find_one(problem, guess);
  if (x.size() > 0)
    result.found.push_back(x);
  else
    result.uniqueness = Uniqueness::Unproven;
  return result;
}

}  // namespace

ContactSolutions find_all(const ContactProblem& problem, std::size_t most_modes, const VectorXd& guess) {
  if (is_monotone(problem)) {
    ContactSolutions result = found_one(problem, Uniqueness::Proven, guess, "");
    if (!result.found.empty()) return result;
  }
  const auto& contacts = problem.contacts;
  const auto on_surface = [](const auto& contact) { return contact.dimension > 1; };
  const bool all_on_curves = std::none_of(contacts.begin(), contacts.end(), on_surface);
  if (contacts.size() > most_contacts_counted)
    return found_one(problem, Uniqueness::Unproven, guess, "modes of more than ten contacts are too many to try");
  if (!all_on_curves) return try_starts(problem, guess);
  const std::optional<VectorXd> normals = find_normals(problem);
  double modes = 1.0;
  for (const auto& contact : contacts) modes *= !contact.moves ? 3.0 : normals ? 2.0 : 1.0;
  if (modes > static_cast<double>(most_modes))
    return found_one(problem, Uniqueness::Unproven, guess, "modes are too many to try where contacts begin to slide");
  Counting counting(problem);
  for_all_modes(problem, normals.has_value(), [&](const std::vector<int>& each) {
    normals ? counting.try_linear_mode(each, *normals) : counting.try_mode(each);
  });
  counting.try_shares();
  return counting.take("");
}

}  // namespace tanor
