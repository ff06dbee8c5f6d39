#include "friction/contact_problem.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/dense.hpp"
#include "friction/mode_search.hpp"
#include "friction/range.hpp"

namespace tanor::detail {

using Eigen::MatrixXd;
using Eigen::VectorXd;

double ContactProblem::acceleration_scale(const VectorXd& x) const {
  if (size() == 0) return 0.0;
  return std::max(a0.lpNorm<Eigen::Infinity>(), (A.cwiseAbs() * x.cwiseAbs()).lpNorm<Eigen::Infinity>());
}

double ContactProblem::mobility(std::size_t contact) const {
  return A.diagonal().segment(contacts[contact].first, contacts[contact].dimension).maxCoeff();
}

bool ContactProblem::pulls(const VectorXd& x) const {
  double largest = x.size() > 0 ? x.lpNorm<Eigen::Infinity>() : 0.0, least = 0.0;
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const Eigen::Vector3d N = normal_force(c, x);
    largest = std::max(largest, N.norm());
    if (is_one_sided(c)) least = std::min(least, N.dot(outward[c]));
  }
  return least < -obeys_below * largest;
}

VectorXd ContactProblem::defect(const VectorXd& x, const VectorXd& a, double least_mobility, MatrixXd* J) const {
  // If contacts share a load, a small multiple of x in the derivative leads to the nearest share.
  constexpr double share = 1e-7;
  VectorXd F(x.size());
  const double least = x.size() > 0 ? least_mobility * A.diagonal().lpNorm<Eigen::Infinity>() : 0.0;
  if (J != nullptr) J->setZero(x.size(), x.size());
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto [first, dimension, moves, mu] = contacts[c];
    const Eigen::Vector3d N = normal_force(c, x);
    const double size = N.norm(), h = mu * size;
    Eigen::RowVectorXd dh;
    if (J != nullptr) dh = mu * N.normalized().transpose() * W.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    if (moves) {
      F(first) = x(first) - h;
      if (J != nullptr) {
        J->row(first) = -dh;
        (*J)(first, first) += 1.0;
      }
      continue;
    }
    const double own_A = std::max(mobility(c), least), rho = own_A > 0.0 ? 1.0 / own_A : 0.0;
    const VectorXd own = x.segment(first, dimension), z = own - rho * a.segment(first, dimension);
    const double length = z.norm();
    const bool sticks = length <= h;
    F.segment(first, dimension) = sticks ? VectorXd(own - z) : VectorXd(own - h / length * z);
    if (J == nullptr) continue;
    auto rows = J->middleRows(first, dimension);
    const MatrixXd unit = MatrixXd::Identity(dimension, dimension);
    const MatrixXd A_rows = rho * A.middleRows(first, dimension);
    if (sticks) {
      rows = A_rows;
      rows.middleCols(first, dimension) += share * unit;
      continue;
    }
    const VectorXd e = z / length;
    const MatrixXd turn = h / length * (unit - e * e.transpose());
    rows = turn * A_rows - e * dh;
    rows.middleCols(first, dimension) += unit - turn;
  }
  return F;
}

double ContactProblem::residual(const VectorXd& x) const {
  constexpr double least_mobility = 1e-12;
  if (!x.allFinite()) return std::numeric_limits<double>::infinity();
  VectorXd a = accelerations(x);
  const double least = x.size() > 0 ? least_mobility * A.diagonal().lpNorm<Eigen::Infinity>() : 0.0;
  const double largest_a = acceleration_scale(x);
  double worst = 0.0, scale = x.lpNorm<Eigen::Infinity>();
  for (std::size_t c = 0; c < contacts.size(); ++c) {
    const auto [first, dimension, moves, mu] = contacts[c];
    scale = std::max(scale, limit(c, x));
    // Accelerations below rounding count as 0.
    if (a.segment(first, dimension).norm() <= 1e-11 * largest_a) a.segment(first, dimension).setZero();
    const double own_A = moves ? 0.0 : std::max(mobility(c), least);
    if (own_A > 0.0) scale = std::max(scale, a0.segment(first, dimension).norm() / own_A);
  }
  const VectorXd F = defect(x, a, least_mobility, nullptr);
  for (const auto& contact : contacts) worst = std::max(worst, F.segment(contact.first, contact.dimension).norm());
  return worst == 0.0 ? 0.0 : worst / scale;
}

bool ContactProblem::are_same(const VectorXd& x, const VectorXd& y) const {
  constexpr double digits = 1e-8;
  const double scale = std::max(acceleration_scale(x), acceleration_scale(y));
  return (A * (x - y)).lpNorm<Eigen::Infinity>() <= digits * scale;
}

// ---- proofs ----

double ContractionBound::amplification(const ContactProblem& problem) {
  const Eigen::Index m = problem.size();
  R_.resize(m, m);
  for (Eigen::Index c = 0; c < m; ++c)
    R_.row(c) = problem.contacts[static_cast<std::size_t>(c)].mu * problem.W.middleRows<3>(3 * c).colwise().norm();
  return amplification(R_);
}

/// For R >= 0, rho(R) < 1 exactly if I - R is a nonsingular M-matrix, that is, if elimination without exchanges has
/// positive pivots (Berman and Plemmons 1994, ch. 6). Then x = (I - R)^-1 1 >= 1, and |e| <= (I - R)^-1 |F(s) - s|.
double ContractionBound::amplification(const MatrixXd& R) {
  constexpr double unproven = std::numeric_limits<double>::quiet_NaN();
  const Eigen::Index m = R.rows();
  // A = L U
  A_ = -R;
  A_.diagonal().array() += 1.0;
  for (Eigen::Index k = 0; k < m; ++k) {
    const Eigen::Index rest = m - k - 1;
    if (!(A_(k, k) > 0.0)) return unproven;
    A_.col(k).tail(rest) /= A_(k, k);
    A_.bottomRightCorner(rest, rest).noalias() -= A_.col(k).tail(rest) * A_.row(k).tail(rest);
  }
  x_.setOnes(m);
  A_.triangularView<Eigen::UnitLower>().solveInPlace(x_);
  A_.triangularView<Eigen::Upper>().solveInPlace(x_);
  // If I - R is nearly singular, x has no correct digits and proves nothing.
  double largest = 1.0;
  for (Eigen::Index c = 0; c < m; ++c) {
    const double rest = x_(c) - 1.0 - R.row(c).dot(x_);
    if (!(std::abs(rest) < 1e-3 && x_(c) >= 1.0 - 1e-9)) return unproven;
    largest = std::max(largest, x_(c));
  }
  return std::isfinite(largest) ? largest : unproven;
}

bool is_proven_unique(const ContactProblem& problem) {
  const bool all_move = std::ranges::all_of(problem.contacts, [](const auto& contact) { return contact.moves; });
  if (all_move && !std::isnan(ContractionBound().amplification(problem))) return true;
  constexpr double rounding = 1e-11;
  std::vector<std::size_t> coupled;  // contacts whose reaction friction changes
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    const double change = problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c)).norm();
    if (problem.contacts[c].mu * change <= rounding) continue;
    if (problem.contacts[c].moves) return false;
    coupled.push_back(c);
  }
  if (coupled.empty()) return true;
  // With A = L L' and z = L'y, y'A y = |z|^2. The bound is the largest eigenvalue of the sum of mu (s L_c'L_c +
  // V_c'V_c/s)/2, where W = V L' and s = |V_c|/|L_c|.
  const Range range(problem.A, rounding);
  const Eigen::Index rank = range.rank();
  const VectorXd root = range.values.cwiseSqrt();
  const MatrixXd L = range.vectors * root.asDiagonal(),
                 V = problem.W * range.vectors * root.cwiseInverse().asDiagonal();
  MatrixXd sum = MatrixXd::Zero(rank, rank);
  for (const std::size_t c : coupled) {
    const auto& contact = problem.contacts[c];
    const auto rows = problem.W.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    if (contact.mu * (rows * range.null).norm() > rounding * std::max(1.0, rows.norm())) return false;
    const auto own_L = L.middleRows(contact.first, contact.dimension);
    const auto own_V = V.middleRows<3>(3 * static_cast<Eigen::Index>(c));
    const double size_L = own_L.norm(), size_V = own_V.norm();
    if (size_L == 0.0 || size_V == 0.0) continue;
    const double s = size_V / size_L;
    sum += 0.5 * contact.mu * (s * own_L.transpose() * own_L + own_V.transpose() * own_V / s);
  }
  return rank == 0 || dense::find_eigen(sum).values.maxCoeff() < 1.0 - 1e-6;
}

// ---- one motion ----

namespace {

/// Solves by Newton's method, with shorter steps if a whole one leads away. Returns true if it converged.
bool solve_by_newton(const ContactProblem& problem, VectorXd* x) {
  constexpr int most_steps = 40, patience = 8;
  const auto defect = [&](const VectorXd& at, MatrixXd* J) {
    return problem.defect(at, problem.accelerations(at), 1e-9, J);
  };
  MatrixXd J;
  VectorXd F = defect(*x, &J);
  double size = F.norm(), best = size;
  int since_best = 0;
  for (int step = 0; step < most_steps; ++step) {
    if (size <= 1e-14 * x->norm()) return true;
    const VectorXd dx = dense::solve(J, F);
    if (!dx.allFinite()) return false;
    VectorXd trial;
    double factor = 1.0, trial_size = 0.0;
    for (int cut = 0; cut < 6; ++cut, factor *= 0.5) {
      trial = *x - factor * dx;
      trial_size = defect(trial, nullptr).norm();
      if (trial_size < (1.0 - 0.1 * factor) * size) break;
    }
    if (!std::isfinite(trial_size)) return false;
    *x = trial;
    F = defect(*x, &J);
    size = F.norm();
    since_best = size < 0.9 * best ? 0 : since_best + 1;
    best = std::min(best, size);
    if (since_best >= patience) return size <= 1e-10 * x->norm();
  }
  return size <= 1e-10 * x->norm();
}

}  // namespace

VectorXd find_one(const ContactProblem& problem, const VectorXd& guess) {
  const auto obeys = [&](const VectorXd& x) { return problem.residual(x) <= obeys_below; };
  const auto refine = [&](const VectorXd& from) {
    VectorXd x = from;
    return solve_by_newton(problem, &x) && obeys(x) ? x : VectorXd();
  };
  VectorXd x = guess.size() == problem.size() ? guess : VectorXd(VectorXd::Zero(problem.size()));
  if (VectorXd found = refine(x); found.size() > 0) return found;
  constexpr int most_rounds = 60;
  VectorXd limits(static_cast<Eigen::Index>(problem.contacts.size()));
  for (int round = 0; round < most_rounds; ++round) {
    for (std::size_t c = 0; c < problem.contacts.size(); ++c)
      limits(static_cast<Eigen::Index>(c)) = problem.limit(c, x);
    x = solve_convex_law(problem, limits);
    if (obeys(x)) return x;
    if (VectorXd found = refine(x); found.size() > 0) return found;
  }
  return {};
}

// ---- all motions ----

namespace {

/// Adds a solution unless its motion is known. Returns true if it obeys the law.
bool add_motion(const ContactProblem& problem, const VectorXd& x, std::vector<VectorXd>* found) {
  if (x.size() != problem.size() || !x.allFinite() || !(problem.residual(x) <= obeys_below)) return false;
  if (problem.pulls(x)) return true;
  const auto same = [&](const VectorXd& other) { return problem.are_same(x, other); };
  if (std::none_of(found->begin(), found->end(), same)) found->push_back(x);
  return true;
}

/// Adds what Newton's method finds from `guess` and from other starts. There may be several motions, and nothing is
/// proven.
void try_starts(const ContactProblem& problem, const VectorXd& guess, int starts, std::vector<VectorXd>* found) {
  (void)add_motion(problem, find_one(problem, guess), found);
  if (starts == 0) return;
  const VectorXd rest = -dense::solve_least_squares(problem.A, problem.a0);
  (void)add_motion(problem, rest, found);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < starts; ++k) {
    VectorXd x = rest;
    for (Eigen::Index i = 0; k > 0 && i < x.size(); ++i) x(i) = normal(random) * (1.0 + rest.lpNorm<Eigen::Infinity>());
    (void)add_motion(problem, find_one(problem, x), found);
  }
}

/// Tries all signs sigma of the normal forces, N_c along sigma_c n_c, of contacts that all move with one line n_c each;
/// guides to one side have one sign:
/// (I - sigma mu n.W) x = sigma mu n.N0 has one solution, which obeys the law if no x_c is negative. Returns false if
/// there are other contacts, or if some solution is uncertain or beyond what is searched for.
bool try_signs(const ContactProblem& problem, std::vector<VectorXd>* found) {
  constexpr double rounding = 1e-11;
  const Eigen::Index m = problem.size();
  double unit = 0.0;
  std::size_t given = 0, negative = 0;  // signs that are given, and those of them that are -1
  for (std::size_t c = 0; c < problem.contacts.size(); ++c) {
    if (!problem.contacts[c].moves) return false;
    unit = std::max(unit, problem.contacts[c].mu * problem.N0.segment<3>(3 * static_cast<Eigen::Index>(c)).norm());
  }
  if (unit == 0.0) unit = 1.0;
  Eigen::Matrix3Xd all(3, m + 1);
  MatrixXd R(m, m + 1), J(m, m);
  for (Eigen::Index c = 0; c < m; ++c) {
    all << problem.W.middleRows<3>(3 * c), problem.N0.segment<3>(3 * c) / unit;
    all *= problem.contacts[static_cast<std::size_t>(c)].mu;
    Eigen::Index longest = 0;
    (void)all.colwise().squaredNorm().maxCoeff(&longest);
    const Eigen::Vector3d line = all.col(longest).normalized();
    R.row(c) = line.transpose() * all;
    if ((all - line * R.row(c)).norm() > rounding * std::max(1.0, all.norm())) return false;
    const auto contact = static_cast<std::size_t>(c);
    if (!problem.is_one_sided(contact)) continue;
    given |= std::size_t{1} << c;
    if (line.dot(problem.outward[contact]) < 0.0) negative |= std::size_t{1} << c;
  }
  std::vector<VectorXd> obeying;
  VectorXd sigma(m);
  dense::Lu lu;
  for (std::size_t signs = 0; signs < std::size_t{1} << m; ++signs) {
    if ((signs & given) != negative) continue;
    for (Eigen::Index c = 0; c < m; ++c) sigma(c) = (signs >> c) & 1 ? -1.0 : 1.0;
    J = -(sigma.asDiagonal() * R.leftCols(m));
    J.diagonal().array() += 1.0;
    lu.compute(J);
    const VectorXd x = lu.solve(sigma.cwiseProduct(R.col(m)));
    if (!x.allFinite()) return false;
    const double size = x.lpNorm<Eigen::Infinity>();
    if (x.minCoeff() < -0.5 * obeys_below * size) continue;
    if (size > LinearProgram::most || !add_motion(problem, unit * x, &obeying)) return false;
  }
  found->swap(obeying);
  return true;
}

}  // namespace

ContactSolutions find_all(const ContactProblem& problem, std::size_t* work_left, const VectorXd& guess,
                          int other_starts) {
  ContactSolutions result;
  if (is_proven_unique(problem)) {
    try_starts(problem, guess, 0, &result.found);
    result.uniqueness = Uniqueness::Proven;
    result.is_complete = true;
    if (!result.found.empty()) return result;
  }
  result.uniqueness = Uniqueness::Unproven;
  result.is_complete = false;
  if (problem.contacts.size() > most_contacts_counted) {
    try_starts(problem, guess, 0, &result.found);
    result.reason = "modes of more than ten contacts are too many to try";
    return result;
  }
  if (!try_signs(problem, &result.found)) {
    ModeSearch search(problem, *work_left);
    search.run();
    *work_left -= std::min(*work_left, search.work);
    result.reason = search.reason;
    for (const VectorXd& x : search.found) {
      if (!add_motion(problem, x, &result.found) && result.reason.empty())
        result.reason = "rounding hides whether one more motion obeys the law";
    }
  }
  result.is_complete = result.reason.empty();
  if (!result.is_complete && result.found.size() < 2) try_starts(problem, guess, other_starts, &result.found);
  result.uniqueness = result.found.size() > 1 ? Uniqueness::Several
                      : !result.is_complete   ? Uniqueness::Unproven
                      : result.found.empty()  ? Uniqueness::None
                                              : Uniqueness::Proven;
  return result;
}

}  // namespace tanor::detail
