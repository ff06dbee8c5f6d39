#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "dynamics/friction_stage.hpp"

/// \file Islands with few Coulomb contacts of FrictionStage: what their normal forces make of friction, as a small
/// dense problem each, all of whose solutions can be found.
namespace tanor {

/// The contacts that slide under laws that read multipliers, island by island.
void FrictionStage::list_sliding() {
  sliding_.resize(islands_.size());
  for (std::size_t number = 0; number < islands_.size(); ++number) {
    SlidingIsland& island = sliding_[number];
    island.number = number;
    island.members.clear();
    for (const std::size_t c : islands_[number]) {
      if (!tangents_.sticks(c) && !laws_.is_given(c)) island.members.push_back(c);
    }
  }
}

/// N0 and W of each island, from the multipliers without their friction and from those that one newton against the
/// sliding of each contact adds: of the j-th contact of every island at once, since islands do not see each other.
void FrictionStage::reduce() {
  std::size_t most = 0;
  for (const SlidingIsland& island : sliding_) most = std::max(most, island.members.size());
  const auto as_eigen = [](Vec3 a) { return Eigen::Vector3d(a.x, a.y, a.z); };
  std::vector<double>&force = force_, &lambda = response_to_force_;
  force.resize(x_.size());
  lambda.assign(lambda_.size(), 0.0);
  const auto fill = [&](const SlidingIsland& island, Eigen::Matrix3Xd* N) {
    N->resize(3, static_cast<Eigen::Index>(island.members.size()));
    for (std::size_t c = 0; c < island.members.size(); ++c)
      N->col(static_cast<Eigen::Index>(c)) = as_eigen(laws_.normal_force(island.members[c], lambda.data()));
  };
  laws_.evaluate(model_.parallel, lambda.data(), force.data());  // what reads no multiplier stays
  find_multipliers(force.data(), lambda.data());
  for (SlidingIsland& island : sliding_) {
    island.contacts.mu.clear();
    for (const std::size_t c : island.members) island.contacts.mu.push_back(laws_.coefficient(c));
    fill(island, &island.contacts.N0);
    island.contacts.W.resize(island.members.size());
  }
  for (std::size_t j = 0; j < most; ++j) {
    std::fill(force.begin(), force.end(), 0.0);
    for (const SlidingIsland& island : sliding_) {
      if (j < island.members.size()) force[laws_.first_part(island.members[j])] = 1.0;
    }
    find_change(force.data(), lambda.data());
    for (SlidingIsland& island : sliding_) {
      if (j < island.members.size()) fill(island, &island.contacts.W[j]);
    }
  }
}

/// Coulomb friction alone, of at most `most` contacts each.
bool FrictionStage::are_small(std::size_t most) const {
  return std::all_of(sliding_.begin(), sliding_.end(), [&](const SlidingIsland& island) {
    return island.members.size() <= most && std::all_of(island.members.begin(), island.members.end(),
                                                        [&](std::size_t c) { return laws_.is_coulomb(c); });
  });
}

/// Theorem A: a law by full reactions is a contraction in the norm of M^-1, |tau(e1) - tau(e2)| <= mu |e1 - e2|,
/// whatever S is. Returns 1/(1 - mu) with what the norm may hide; NaN where some law is another one.
double FrictionStage::amplification_of_full_reactions() const {
  double mu = 0.0;
  for (const SlidingIsland& island : sliding_) {
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

std::string FrictionStage::name_island(const SlidingIsland& island) const {
  return model_.name_contact(island.members.front()) + (island.members.size() > 1 ? " and others of its island" : "");
}

/// With these sizes of friction, contacts of the island that stick bear no more than they can.
bool FrictionStage::holds_what_sticks(const SlidingIsland& island, const Eigen::VectorXd& sizes) {
  const auto& all = islands_[island.number];
  if (std::none_of(all.begin(), all.end(), [&](std::size_t c) { return tangents_.sticks(c); })) return true;
  std::vector<double> force(x_.size()), lambda(lambda_.size(), 0.0);
  laws_.evaluate(model_.parallel, lambda_.data(), force.data());
  for (std::size_t c = 0; c < island.members.size(); ++c)
    force[laws_.first_part(island.members[c])] = sizes(static_cast<Eigen::Index>(c));
  find_multipliers(force.data(), lambda.data());
  constexpr double slack = 1.0 + 1e-9;
  return std::all_of(all.begin(), all.end(), [&](std::size_t c) {
    return !tangents_.sticks(c) || norm(held(c, lambda.data())) <= slack * static_limit(c, lambda.data());
  });
}

Outcome FrictionStage::refuse_several_of(const SlidingIsland& island, std::size_t count, double t) {
  report_.uniqueness = Uniqueness::Several;
  if (!several_are_refused_) return {};
  return fail(Status::NotUnique, t, name_island(island) + ": " + std::to_string(count) + " accelerations obey the law");
}

/// Islands of many contacts whose friction changes no reaction, W = 0, have one solution: one solve for any friction of
/// all contacts tells it. Their members are done with.
void FrictionStage::leave_out_uncoupled(std::size_t least_contacts) {
  const auto is_many = [&](const SlidingIsland& island) { return island.members.size() >= least_contacts; };
  if (std::none_of(sliding_.begin(), sliding_.end(), is_many)) return;
  std::vector<double>&force = force_, &lambda = response_to_force_;
  force.assign(x_.size(), 0.0);
  lambda.assign(lambda_.size(), 0.0);
  constexpr double golden = 0.6180339887498949;
  double turn = 0.0;
  for (const SlidingIsland& island : sliding_) {
    for (const std::size_t c : island.members) {
      turn += golden - (turn + golden >= 1.0 ? 1.0 : 0.0);
      force[laws_.first_part(c)] = 0.5 + turn;  // of no pattern
    }
  }
  find_change(force.data(), lambda.data());
  constexpr double rounding = 1e-11;
  for (SlidingIsland& island : sliding_) {
    const bool is_uncoupled = std::all_of(island.members.begin(), island.members.end(), [&](std::size_t c) {
      return laws_.is_coulomb(c) && laws_.coefficient(c) * norm(laws_.normal_force(c, lambda.data())) <= rounding;
    });
    if (is_many(island) && is_uncoupled) island.members.clear();
  }
}

/// A solution is there: is it the only one?
Outcome FrictionStage::judge(double t) {
  report_.uniqueness = Uniqueness::Unproven;
  list_sliding();
  amplification_ = amplification_of_full_reactions();
  if (!std::isnan(amplification_)) {
    report_.uniqueness = Uniqueness::Proven;
    return {};
  }
  bool is_proven = true;
  const auto leave_open = [&](SlidingIsland* island, const std::string& why) {
    if (is_proven) report_.uniqueness_reason = name_island(*island) + ": " + why;
    is_proven = false;
    island->members.clear();
  };
  leave_out_uncoupled(most_enumerated + 1);
  for (SlidingIsland& island : sliding_) {
    const bool are_coulomb =
        std::all_of(island.members.begin(), island.members.end(), [&](std::size_t c) { return laws_.is_coulomb(c); });
    if (!are_coulomb)
      leave_open(&island, "solutions of laws other than Coulomb's are not counted");
    else if (island.members.size() > most_judged)
      leave_open(&island, "so many contacts that slide and change each other's reactions are not judged");
  }
  reduce();
  amplification_ = is_proven ? 1.0 : std::numeric_limits<double>::quiet_NaN();
  for (SlidingIsland& island : sliding_) {
    if (island.members.empty()) continue;
    const double amplification = contraction_.amplification(island.contacts);
    amplification_ = larger(amplification_, amplification);
    if (!std::isnan(amplification)) continue;  // one motion
    SlidingSolutions solutions = find_sliding(island.contacts);
    if (is_counted(island)) continue;
    // Two sizes of friction are no two motions where one of them is more than what sticks can bear.
    if (solutions.uniqueness == Uniqueness::Several) {
      std::erase_if(solutions.found, [&](const Eigen::VectorXd& s) { return !holds_what_sticks(island, s); });
      if (solutions.found.size() < 2)
        solutions.uniqueness = solutions.is_complete ? Uniqueness::Proven : Uniqueness::Unproven;
    }
    if (solutions.uniqueness == Uniqueness::Several) {
      is_proven = false;
      if (Outcome outcome = refuse_several_of(island, solutions.found.size(), t); !outcome.ok()) return outcome;
    } else if (solutions.uniqueness != Uniqueness::Proven) {
      leave_open(&island, island.members.size() > most_enumerated
                              ? "(43) is no contraction, and modes of more than ten contacts are too many to try"
                              : "(43) is no contraction, and the search for other sizes of friction became too long");
    }
  }
  if (is_proven && report_.uniqueness != Uniqueness::Several) report_.uniqueness = Uniqueness::Proven;
  return {};
}

/// By trying, where iterations fail: of several solutions the one nearest to `lambda`.
Outcome FrictionStage::enumerate(double t, double* lambda) {
  list_sliding();
  if (!are_small(most_enumerated)) {
    return fail(Status::NotConverged, t,
                "its iterations do not converge, and contacts are too many to try all signs of their normal forces, or "
                "their law is not Coulomb's");
  }
  reduce();
  report_.method_used = FrictionMethod::Enumeration;
  std::vector<double> force(x_.size());
  const std::vector<double> nothing(lambda_.size(), 0.0);
  laws_.evaluate(model_.parallel, nothing.data(), force.data());
  for (const SlidingIsland& island : sliding_) {
    if (island.members.empty()) continue;
    SlidingSolutions solutions = find_sliding(island.contacts);
    if (solutions.uniqueness == Uniqueness::None) {
      report_.uniqueness = Uniqueness::None;
      return fail(
          Status::NoSolution, t,
          name_island(island) + ": no accelerations obey the law (" +
              (solutions.determinant_changes ? "the determinant changes its sign, Painleve" : "all signs were tried") +
              "); the rods jam, and the velocity would have to jump");
    }
    if (solutions.uniqueness == Uniqueness::Several && !is_counted(island)) {
      if (Outcome outcome = refuse_several_of(island, solutions.found.size(), t); !outcome.ok()) return outcome;
    }
    if (solutions.found.empty()) add_by_iteration(island.contacts, &solutions.found);
    if (solutions.found.empty()) return fail(Status::NotConverged, t, name_island(island) + ": no iteration converges");
    const auto distance = [&](const Eigen::VectorXd& s) {
      double sum = 0.0;
      for (std::size_t c = 0; c < island.members.size(); ++c) {
        const double before = island.contacts.mu[c] * norm(laws_.normal_force(island.members[c], lambda));
        sum += std::pow(s(static_cast<Eigen::Index>(c)) - before, 2);
      }
      return sum;
    };
    const auto nearest = std::min_element(solutions.found.begin(), solutions.found.end(),
                                          [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
    for (std::size_t c = 0; c < island.members.size(); ++c)
      force[laws_.first_part(island.members[c])] = (*nearest)(static_cast<Eigen::Index>(c));
  }
  find_multipliers(force.data(), lambda);
  ++report_.iterations;
  return {};
}

}  // namespace tanor
