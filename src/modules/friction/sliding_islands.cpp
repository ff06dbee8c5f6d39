#include "friction/sliding_islands.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

ContactIslands::ContactIslands(const Workspace& work) : of_contact(work.constraints.tangents().size()) {
  const Tangents& tangents = work.constraints.tangents();
  const Numbering& numbering = work.model().numbering;
  contacts.resize(numbering.num_islands());
  for (std::size_t c = 0; c < tangents.size(); ++c)
    contacts[numbering.island_of(tangents[c].guide_row[0])].push_back(c);
  std::erase_if(contacts, [](const auto& island) { return island.empty(); });
  for (std::size_t island = 0; island < contacts.size(); ++island) {
    for (const std::size_t c : contacts[island]) of_contact[c] = island;
  }
}

Eigen::Vector3d outward(const Tangents& tangents, std::size_t contact) {
  const Vec3 k = tangents.normals(contact)[0];
  const double size = tangents[contact].side == 0.0 ? 0.0 : tangents[contact].side / norm(k);
  return size * Eigen::Vector3d(k.x, k.y, k.z);
}

SlidingIslands::SlidingIslands(const Workspace& work, const FrictionLaws& laws, const ContactIslands& islands,
                               Response& response)
    : work_(work),
      model_(work.model()),
      tangents_(work.constraints.tangents()),
      laws_(laws),
      numbered_(islands),
      response_(response),
      islands_(islands.size()) {
  for (std::size_t number = 0; number < islands_.size(); ++number) islands_[number].number = number;
}

/// Lists the contacts that slide under laws that read multipliers, for each island.
void SlidingIslands::list_members() {
  for (Island& island : islands_) {
    island.members.clear();
    for (const std::size_t c : numbered_.contacts[island.number]) {
      if (!tangents_.sticks(c) && !tangents_.is_open(c) && !laws_.is_given(c)) island.members.push_back(c);
    }
  }
}

/// Computes N0 and W of each island: the normal forces from the multipliers without their friction, and the change by
/// one newton against the sliding of each contact. The j-th contacts of all islands share one solve, since islands do
/// not affect each other.
void SlidingIslands::reduce() {
  std::size_t most = 0;
  for (const Island& island : islands_) most = std::max(most, island.members.size());
  force_.resize(laws_.num_parts());
  lambda_.assign(model_.num_rows(), 0.0);
  const auto fill = [&](const Island& island, auto&& N) {
    for (std::size_t c = 0; c < island.members.size(); ++c) {
      const Vec3 own = laws_.normal_force(island.members[c], lambda_.data());
      N.template segment<3>(3 * static_cast<Eigen::Index>(c)) << own.x, own.y, own.z;
    }
  };
  laws_.evaluate(model_.parallel, lambda_.data(), force_.data());  // friction that reads no multiplier stays
  response_.find_multipliers(force_.data(), lambda_.data());
  for (Island& island : islands_) {
    ContactProblem& problem = island.problem;
    problem.contacts.clear();
    problem.outward.clear();
    for (const std::size_t c : island.members) {
      problem.contacts.push_back({static_cast<Eigen::Index>(problem.contacts.size()), 1, true, laws_.coefficient(c)});
      problem.outward.push_back(outward(tangents_, c));
    }
    const auto m = static_cast<Eigen::Index>(island.members.size());
    problem.A.setIdentity(m, m);  // solutions of different sizes are different motions
    problem.a0.setZero(m);
    problem.W.resize(3 * m, m);
    problem.N0.resize(3 * m);
    fill(island, problem.N0);
  }
  for (std::size_t j = 0; j < most; ++j) {
    std::fill(force_.begin(), force_.end(), 0.0);
    for (const Island& island : islands_) {
      if (j < island.members.size()) force_[laws_.first_part(island.members[j])] = 1.0;
    }
    response_.find_change(force_.data(), lambda_.data());
    for (Island& island : islands_) {
      if (j < island.members.size()) fill(island, island.problem.W.col(static_cast<Eigen::Index>(j)));
    }
  }
}

bool SlidingIslands::are_coulomb(const Island& island) const {
  return std::all_of(island.members.begin(), island.members.end(), [&](std::size_t c) { return laws_.is_coulomb(c); });
}

/// Theorem A: a law by full reactions is a contraction in the norm of M^-1, |tau(e1) - tau(e2)| <= mu |e1 - e2|, for
/// every S. Returns 1/(1 - mu), times the largest ratio between norms, or NaN if some law is another one.
double SlidingIslands::amplification_of_full_reactions() const {
  double mu = 0.0;
  for (const Island& island : islands_) {
    for (const std::size_t c : island.members) {
      if (!laws_.is_coulomb(c) || !laws_.reads_full_reaction(c)) return std::numeric_limits<double>::quiet_NaN();
      mu = std::max(mu, laws_.coefficient(c));
    }
  }
  if (!(mu < 1.0)) return std::numeric_limits<double>::quiet_NaN();
  const auto end = model_.mass.begin() + static_cast<std::ptrdiff_t>(model_.num_moving());
  const auto [lightest, heaviest] = std::minmax_element(model_.mass.begin(), end);
  return std::sqrt(static_cast<double>(tangents_.size()) * *heaviest / *lightest) / (1.0 - mu);
}

std::string SlidingIslands::name(const Island& island) const {
  return work_.name_contact(island.members.front()) + (island.members.size() > 1 ? " and others of its island" : "");
}

/// Returns true if the sticking contacts of the island hold no more than their limits, with the given sizes of friction
/// in the island and those at the multipliers `at` elsewhere.
bool SlidingIslands::holds_what_sticks(const Island& island, const Eigen::VectorXd& sizes, const double* at) {
  const auto& all = numbered_.contacts[island.number];
  if (std::none_of(all.begin(), all.end(), [&](std::size_t c) { return tangents_.sticks(c); })) return true;
  std::vector<double> force(laws_.num_parts()), lambda(model_.num_rows(), 0.0);
  laws_.evaluate(model_.parallel, at, force.data());
  for (std::size_t c = 0; c < island.members.size(); ++c)
    force[laws_.first_part(island.members[c])] = sizes(static_cast<Eigen::Index>(c));
  response_.find_multipliers(force.data(), lambda.data());
  constexpr double slack = 1.0 + 1e-9;
  return std::all_of(all.begin(), all.end(), [&](std::size_t c) {
    return !tangents_.sticks(c) || norm(laws_.held(c, lambda.data())) <= slack * laws_.static_limit(c, lambda.data());
  });
}

Outcome SlidingIslands::note_several(const Island& island, std::size_t count, double t, const UniquenessCheck& check,
                                     FrictionReport* report) const {
  report->uniqueness = Uniqueness::Several;
  if (!check.refuses_several) return {};
  return fail_friction(Status::NotUnique, t,
                       name(island) + ": " + std::to_string(count) + " accelerations obey the law");
}

/// Removes the members of large islands whose friction changes no reaction, W = 0, so that they have one solution. One
/// solve with some friction at all contacts tells it.
void SlidingIslands::leave_out_uncoupled(std::size_t least_contacts) {
  const auto is_many = [&](const Island& island) { return island.members.size() >= least_contacts; };
  if (std::none_of(islands_.begin(), islands_.end(), is_many)) return;
  force_.assign(laws_.num_parts(), 0.0);
  lambda_.assign(model_.num_rows(), 0.0);
  constexpr double golden = 0.6180339887498949;
  double turn = 0.0;
  for (const Island& island : islands_) {
    for (const std::size_t c : island.members) {
      turn += golden - (turn + golden >= 1.0 ? 1.0 : 0.0);
      force_[laws_.first_part(c)] = 0.5 + turn;  // an irregular sequence
    }
  }
  response_.find_change(force_.data(), lambda_.data());
  constexpr double rounding = 1e-11;
  for (Island& island : islands_) {
    const bool is_uncoupled = std::all_of(island.members.begin(), island.members.end(), [&](std::size_t c) {
      return laws_.is_coulomb(c) && laws_.coefficient(c) * norm(laws_.normal_force(c, lambda_.data())) <= rounding;
    });
    if (is_many(island) && is_uncoupled) island.members.clear();
  }
}

/// Returns the sizes of friction of the members at the multipliers `at`.
Eigen::VectorXd SlidingIslands::sizes(const Island& island, const double* at) const {
  Eigen::VectorXd result(static_cast<Eigen::Index>(island.members.size()));
  for (std::size_t c = 0; c < island.members.size(); ++c)
    result(static_cast<Eigen::Index>(c)) =
        island.problem.contacts[c].mu * norm(laws_.normal_force(island.members[c], at));
  return result;
}

/// Finds all solutions of an island. Two sizes of friction are two motions only if sticking contacts can bear both. In
/// the middle of a run the motion at hand is enough where the search is not complete.
ContactSolutions SlidingIslands::count(const Island& island, const UniquenessCheck& check, const double* at) {
  std::size_t work_left = most_work(check.refuses_several);
  ContactSolutions solutions = check.refuses_several ? find_all(island.problem, &work_left, sizes(island, at))
                                                     : find_all(island.problem, &work_left, sizes(island, at), 0);
  if (solutions.uniqueness != Uniqueness::Several) return solutions;
  std::erase_if(solutions.found, [&](const Eigen::VectorXd& s) { return !holds_what_sticks(island, s, at); });
  if (solutions.found.size() < 2)
    solutions.uniqueness = solutions.is_complete ? Uniqueness::Proven : Uniqueness::Unproven;
  return solutions;
}

Outcome SlidingIslands::verify_uniqueness(double t, const UniquenessCheck& check, const double* lambda,
                                          FrictionReport* report, double* amplification) {
  constexpr std::size_t most_verified = 64;  // contacts of an island; each costs one solve
  report->uniqueness = Uniqueness::Unproven;
  list_members();
  *amplification = amplification_of_full_reactions();
  if (!std::isnan(*amplification)) {
    report->uniqueness = Uniqueness::Proven;
    return {};
  }
  bool is_proven = true;
  const auto leave_open = [&](Island* island, const std::string& why) {
    if (is_proven) report->uniqueness_reason = name(*island) + ": " + why;
    is_proven = false;
    island->members.clear();
  };
  leave_out_uncoupled(most_contacts_counted + 1);
  for (Island& island : islands_) {
    if (!are_coulomb(island))
      leave_open(&island, "solutions of laws other than Coulomb's are not counted");
    else if (island.members.size() > most_verified)
      leave_open(&island, "so many contacts that slide and change each other's reactions are not checked");
  }
  reduce();
  *amplification = is_proven ? 1.0 : std::numeric_limits<double>::quiet_NaN();
  for (Island& island : islands_) {
    if (island.members.empty()) continue;
    const double own = contraction_.amplification(island.problem);
    *amplification = larger(*amplification, own);
    // The motion is unique, or all motions were counted before.
    if (!std::isnan(own) || is_counted(island, check)) continue;
    if (island.members.size() > most_contacts_counted) {
      leave_open(&island,
                 "the iteration of friction is no contraction, and modes of more than ten contacts are too many "
                 "to try");
      continue;
    }
    const ContactSolutions solutions = count(island, check, lambda);
    if (solutions.uniqueness == Uniqueness::Several) {
      is_proven = false;
      Outcome outcome = note_several(island, solutions.found.size(), t, check, report);
      if (!outcome.ok()) return outcome;
    } else if (solutions.uniqueness != Uniqueness::Proven) {
      leave_open(&island, "the iteration of friction is no contraction, and " + solutions.reason);
    }
  }
  if (is_proven && report->uniqueness != Uniqueness::Several) report->uniqueness = Uniqueness::Proven;
  return {};
}

Outcome SlidingIslands::enumerate(double t, const UniquenessCheck& check, double* lambda, FrictionReport* report) {
  list_members();
  const bool are_small = std::ranges::all_of(islands_, [&](const Island& island) {
    return island.members.size() <= most_contacts_counted && are_coulomb(island);
  });
  if (!are_small) {
    return fail_friction(
        Status::NotConverged, t,
        "its iterations do not converge, and contacts are too many to try all their modes, or their law is not "
        "Coulomb's");
  }
  reduce();
  report->method_used = FrictionMethod::Enumeration;
  std::vector<double> force(laws_.num_parts());
  const std::vector<double> nothing(model_.num_rows(), 0.0);
  laws_.evaluate(model_.parallel, nothing.data(), force.data());
  for (const Island& island : islands_) {
    if (island.members.empty()) continue;
    Outcome outcome = choose_nearest(island, t, check, lambda, force.data(), report);
    if (!outcome.ok()) return outcome;
  }
  response_.find_multipliers(force.data(), lambda);
  ++report->iterations;
  return {};
}

/// Writes the solution of one island nearest to the friction at lambda into `force` [parts].
Outcome SlidingIslands::choose_nearest(const Island& island, double t, const UniquenessCheck& check,
                                       const double* lambda, double* force, FrictionReport* report) const {
  const Eigen::VectorXd before = sizes(island, lambda);
  std::size_t work_left = most_work(check.refuses_several);
  ContactSolutions solutions = find_all(island.problem, &work_left, before);
  if (solutions.uniqueness == Uniqueness::None) {
    report->uniqueness = Uniqueness::None;
    return fail_friction(Status::NoSolution, t,
                         name(island) +
                             ": no accelerations obey the law, all modes were tried (Painleve); the rods jam, and the "
                             "velocity would have to jump");
  }
  if (solutions.uniqueness == Uniqueness::Several && !is_counted(island, check)) {
    Outcome outcome = note_several(island, solutions.found.size(), t, check, report);
    if (!outcome.ok()) return outcome;
  }
  if (solutions.found.empty()) return fail_friction(Status::NotConverged, t, name(island) + ": no iteration converges");
  const auto nearest = std::min_element(
      solutions.found.begin(), solutions.found.end(),
      [&](const auto& a, const auto& b) { return (a - before).squaredNorm() < (b - before).squaredNorm(); });
  for (std::size_t c = 0; c < island.members.size(); ++c)
    force[laws_.first_part(island.members[c])] = (*nearest)(static_cast<Eigen::Index>(c));
  return {};
}

}  // namespace tanor::detail
