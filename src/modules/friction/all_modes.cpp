#include <algorithm>
#include <random>

#include "base/dense.hpp"
#include "friction/contact_problem.hpp"
#include "friction/mode_search.hpp"

/// \file Finds all motions of a ContactProblem: proves that there is one, counts them by trying all modes, or finds
/// some from several starts.
namespace tanor::detail {

namespace {

using Eigen::VectorXd;

/// Adds a solution unless its motion is known. Returns true if it obeys the law.
bool add_motion(const ContactProblem& problem, const VectorXd& x, std::vector<VectorXd>* found) {
  if (x.size() != problem.size() || !x.allFinite() || !(problem.residual(x) <= obeys_below)) return false;
  const auto same = [&](const VectorXd& other) { return problem.are_same(x, other); };
  if (std::none_of(found->begin(), found->end(), same)) found->push_back(x);
  return true;
}

/// Adds what Newton's method finds from `guess` and from other starts. There may be several motions, and nothing is
/// proven.
void try_starts(const ContactProblem& problem, const VectorXd& guess, int starts, std::vector<VectorXd>* found) {
  const VectorXd rest = -dense::solve_least_squares(problem.A, problem.a0);
  (void)add_motion(problem, find_one(problem, guess), found);
  if (starts > 0) (void)add_motion(problem, rest, found);
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int k = 0; k < starts; ++k) {
    VectorXd x = rest;
    for (Eigen::Index i = 0; k > 0 && i < x.size(); ++i) x(i) = normal(random) * (1.0 + rest.lpNorm<Eigen::Infinity>());
    (void)add_motion(problem, find_one(problem, x), found);
  }
}

}  // namespace

ContactSolutions find_all(const ContactProblem& problem, std::size_t* work_left, const VectorXd& guess) {
  ContactSolutions result;
  if (is_monotone(problem)) {
    try_starts(problem, guess, 0, &result.found);
    result.uniqueness = Uniqueness::Proven;
    if (!result.found.empty()) return result;
  }
  result.uniqueness = Uniqueness::Unproven;
  if (problem.contacts.size() > most_contacts_counted) {
    try_starts(problem, guess, 0, &result.found);
    result.reason = "modes of more than ten contacts are too many to try";
    return result;
  }
  ModeSearch search(problem, *work_left);
  search.run();
  *work_left -= std::min(*work_left, search.work);
  for (const VectorXd& x : search.found) {
    if (!add_motion(problem, x, &result.found) && search.reason.empty())
      search.reason = "rounding hides whether one more motion obeys the law";
  }
  constexpr int other_starts = 16;
  if (!search.reason.empty() && result.found.size() < 2) try_starts(problem, guess, other_starts, &result.found);
  result.uniqueness = result.found.size() > 1  ? Uniqueness::Several
                      : !search.reason.empty() ? Uniqueness::Unproven
                      : result.found.empty()   ? Uniqueness::None
                                               : Uniqueness::Proven;
  if (result.uniqueness == Uniqueness::Unproven) result.reason = search.reason;
  return result;
}

}  // namespace tanor::detail
