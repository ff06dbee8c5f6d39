#include "friction/contact_choices.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <set>
#include <string>

#include "base/text.hpp"
#include "base/with_unit.hpp"

namespace tanor::detail {

namespace {

/// Lists vectors with as many digits as tell them apart, and components of rounding size as 0. `scale` is the size of
/// the terms that cancel in them.
std::string list_apart(const std::vector<Vec3>& vectors, double scale) {
  constexpr int least_digits = 4, most_digits = 11;  // behind these is rounding
  std::vector<std::string> texts;
  for (int digits = least_digits; digits <= most_digits; ++digits) {
    const auto component = [&](double x) { return text(std::abs(x) > 1e-11 * scale ? x : 0.0, digits); };
    texts.clear();
    for (const Vec3& a : vectors)
      texts.push_back("(" + component(a.x) + ", " + component(a.y) + ", " + component(a.z) + ")");
    if (std::set<std::string>(texts.begin(), texts.end()).size() == texts.size()) break;
  }
  std::string list = texts.front();
  for (std::size_t k = 1; k < texts.size(); ++k) list += (k + 1 == texts.size() ? " and " : ", ") + texts[k];
  return list;
}

const char* const too_many = "modes of more than ten contacts are too many to try";

/// Finds which contacts stick in the solution x, and how they share their load. An acceleration below the threshold of
/// rest counts as sliding where friction is at its limit and opposes it, unless another share leaves something to
/// spare.
void find_share(bool is_start, ContactChoice* choice) {
  const ContactProblem& problem = choice->problem;
  const Eigen::VectorXd a = problem.accelerations(choice->x);
  const double least = choice->rest_threshold();
  choice->sticks.assign(choice->size(), 0);
  std::vector<std::size_t> slow;
  for (std::size_t c = 0; c < choice->size(); ++c) {
    const auto& [first, dimension, moves, mu] = problem.contacts[c];
    const Eigen::VectorXd own_a = a.segment(first, dimension), own_x = choice->x.segment(first, dimension);
    choice->sticks[c] = !moves && own_a.norm() <= least;
    const bool opposes = own_a.norm() > 1e-3 * least && choice->is_at_limit(c, choice->x, 1.0 - rounding_of_limits) &&
                         -own_x.dot(own_a) > (1.0 - 1e-6) * own_x.norm() * own_a.norm();
    if (choice->sticks[c] != 0 && opposes) slow.push_back(c);
  }
  // At a start a few contacts take the least friction, if it obeys the law.
  const bool prefers_least = is_start && choice->size() <= most_contacts_counted;
  const auto share = [&] {
    choice->share = choice->x;
    choice->load = share_load(problem, choice->sticks, prefers_least, &choice->share, &choice->weights);
  };
  share();
  if (slow.empty() || choice->load < 1.0 - ContactState::to_spare) return;
  for (const std::size_t c : slow) choice->sticks[c] = 0;
  share();
}

/// Gives kinetic friction to the contacts that begin to move. Returns true if some contact has become weaker by that.
bool release_beginning(const FrictionLaws& laws, const ContactChoice& choice, std::vector<char>* released) {
  bool has_released = false;
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const std::size_t contact = choice.members[c];
    if (!choice.begins(c) || (*released)[contact] != 0) continue;
    if (laws.static_coefficient(contact) <= laws.coefficient_of_sliding(contact)) continue;
    (*released)[contact] = 1;
    has_released = true;
  }
  return has_released;
}

/// Solves with static friction until a contact gives way, then with kinetic friction there, until no other one gives
/// way. `released` [contact] marks those that have given way already, and `lowered` [contact] is the part by which
/// limits are lower in the first pass. Of several motions the one nearest to the last is taken; a start refuses them.
void solve(const ContactState& state, bool is_start, std::vector<char> released, const std::vector<double>& lowered,
           std::size_t* work_left, ContactChoice* choice) {
  const FrictionLaws& laws = state.laws;
  ContactProblem& problem = choice->problem;
  ContactVerdict verdict;
  for (std::size_t pass = 0; pass <= choice->size(); ++pass) {
    for (std::size_t c = 0; c < choice->size(); ++c) {
      const std::size_t contact = choice->members[c];
      if (problem.contacts[c].moves) continue;
      const double whole = pass == 0 ? 1.0 - lowered[contact] : 1.0;
      problem.contacts[c].mu =
          released[contact] != 0 ? laws.coefficient_of_sliding(contact) : whole * laws.static_coefficient(contact);
    }
    ContactSolutions& solutions = choice->solutions =
        find_all(problem, work_left, pass == 0 ? choice->before : choice->x);
    verdict.note(solutions.uniqueness, solutions.reason);
    choice->x.resize(0);
    choice->load = std::numeric_limits<double>::quiet_NaN();
    if (solutions.found.empty()) break;
    // Shares of one load are the same motion, so that friction is compared by the accelerations that it makes.
    const auto distance = [&](const Eigen::VectorXd& x) {
      const Eigen::VectorXd change = x - choice->before;
      return change.dot(problem.A * change);
    };
    const auto nearer = [&](const auto& a, const auto& b) { return distance(a) < distance(b); };
    choice->x = *std::min_element(solutions.found.begin(), solutions.found.end(), nearer);
    find_share(is_start, choice);
    if (!release_beginning(laws, *choice, &released) || (is_start && verdict.uniqueness == Uniqueness::Several)) break;
  }
  choice->solutions.uniqueness = verdict.uniqueness;
  choice->solutions.reason = verdict.reason;
}

/// Lowers the limits of contacts that were held above them and have met their event, but still stick in the choice: a
/// search tells friction from its limit to a part of the largest force of the island, which may be much more than the
/// limit. Returns true if there are any.
bool lower_overloaded(const ContactState& state, const ContactChoice& choice, const std::vector<char>& met,
                      std::vector<double>* lowered) {
  constexpr double told_apart = 1e-8, most = 0.5;
  bool are_some = false;
  for (std::size_t c = 0; choice.has_solution() && c < choice.size(); ++c) {
    const std::size_t contact = choice.members[c];
    if (met[contact] == 0 || state.overloads[contact] == 0 || choice.sticks[c] == 0) continue;
    const double limit = choice.limit(c, choice.x), largest = std::max(choice.x.lpNorm<Eigen::Infinity>(), limit);
    (*lowered)[contact] = std::min(most, told_apart * largest / limit);
    are_some = true;
  }
  return are_some;
}

/// Static friction is tried for all contacts first, and those that it lets move give way, whichever of them has met its
/// event. Where it lets none move, what bears its load alone gives way at its limit. Contacts that share a load do so
/// only if no share is left and `take` does not hold them. So who gives way follows from forces and limits, and not
/// from the rounding by which one contact reached its limit before another.
void choose(const ContactState& state, bool is_start, const std::vector<char>& met, ContactChoice* choice) {
  std::size_t work_left = most_work(is_start);  // of all searches
  std::vector<char> released(met.size(), 0);
  std::vector<double> lowered(met.size(), 0.0);
  solve(state, is_start, released, lowered, &work_left, choice);
  if (lower_overloaded(state, *choice, met, &lowered)) solve(state, is_start, released, lowered, &work_left, choice);
  const auto has_met = [&](std::size_t contact) { return met[contact] != 0; };
  if (!choice->has_solution() || std::ranges::none_of(choice->members, has_met)) return;
  const bool shares = !std::isnan(choice->load);
  const double least_load = 1.0 - (shares ? ContactState::to_spare : rounding_of_limits);
  if (shares && (choice->load < least_load || !choice->keeps_reactions())) return;
  for (std::size_t c = 0; c < choice->size(); ++c) {
    if (choice->begins(c)) return;
    const std::size_t contact = choice->members[c];
    released[contact] = choice->is_at_limit(c, choice->share, least_load) || (!shares && has_met(contact));
  }
  solve(state, is_start, std::move(released), lowered, &work_left, choice);
}

/// Reports that an island has no motion, or lists the several ones.
Outcome explain(const Workspace& work, double t, const ContactChoice& choice) {
  const auto& found = choice.solutions.found;
  const auto name = [&](std::size_t member) { return work.name_contact(choice.members[member]); };
  if (found.size() < 2) {
    return fail_friction(Status::NoSolution, t,
                         name(0) + (choice.size() > 1 ? " and others of its island" : "") +
                             ": no accelerations obey the law (all modes of stick and slip were tried); the "
                             "velocity would have to jump");
  }
  // Find the contact whose accelerations differ most.
  std::size_t worst = 0;
  double most = -1.0;
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const double apart = norm(choice.acceleration(c, found[0]) - choice.acceleration(c, found[1]));
    if (apart <= most) continue;
    most = apart;
    worst = c;
  }
  std::vector<Vec3> accelerations;
  for (const Eigen::VectorXd& x : found) accelerations.push_back(choice.acceleration(worst, x));
  return fail_friction(Status::NotUnique, t,
                       name(worst) + ": " + text(found.size()) + " accelerations obey the law: " +
                           with_unit(list_apart(accelerations, choice.acceleration_scale),
                                     work.model().system.units.letters(Dimension::Acceleration)) +
                           "; at a start nothing says which");
}

/// Reduces the islands while none of their members sticks; other contacts keep their modes. Then calls use() ->
/// Outcome.
template <class Use>
Outcome with_reduced(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                     std::vector<ContactChoice>* choices, const Use& use) {
  std::vector<std::size_t> stuck;
  for (const ContactChoice& choice : *choices) {
    std::ranges::copy_if(choice.members, std::back_inserter(stuck),
                         [&](std::size_t c) { return state.tangents.sticks(c); });
  }
  const auto set_stick = [&](bool sticks) {
    for (const std::size_t c : stuck) state.tangents.set_stick(c, sticks);
    state.forget_shares();
  };
  set_stick(false);
  Outcome outcome = state.system.linearise(at.t, at.r);
  if (outcome.ok()) {
    reduce_islands(state, friction, at, choices);
    outcome = use();
  }
  set_stick(true);
  return outcome;
}

/// Chooses the motion of each island.
Outcome choose_all(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                   std::vector<ContactChoice>* choices) {
  std::vector<char> released(state.size(), 0);
  for (const std::size_t c : at.releases) released[c] = 1;
  Outcome failed;
  for (ContactChoice& choice : *choices) {
    choose(state, at.is_start(), released, &choice);
    const Uniqueness uniqueness = choice.solutions.uniqueness;
    state.verdict.note(uniqueness, choice.solutions.reason);
    const bool is_refused = uniqueness == Uniqueness::None || (uniqueness == Uniqueness::Several && at.is_start());
    if (is_refused && failed.ok()) failed = explain(state.work, at.t, choice);
  }
  guess_multipliers(state, friction, at, *choices);
  if (!failed.ok() && at.to.report != nullptr)
    at.to.report->friction = {.contacts = state.size(), .uniqueness = state.verdict.uniqueness};
  return failed;
}

/// Sets the modes of the members at x. Those that move slide in the direction of their acceleration. Those that were
/// released and are at their limit slide against their friction. All others stick.
void set_modes(ContactState& state, const ModeSwitch& at, const ContactChoice& choice) {
  FrictionLaws& laws = state.laws;
  const Eigen::VectorXd a = choice.problem.accelerations(choice.x);
  const double least = choice.rest_threshold();
  for (std::size_t c = 0; c < choice.size(); ++c) {
    const auto& [first, dimension, moves, mu] = choice.problem.contacts[c];
    if (moves) continue;
    const std::size_t contact = choice.members[c];
    const Vec3 towards = choice.combine(c, a), against = -choice.combine(c, choice.x);
    const bool slides = norm(towards) > least;
    // A contact below its limit shares its load with others, so it does not give way.
    const double limit = choice.limit(c, choice.x);
    const bool gives_way = at.is_released(contact) && choice.x.segment(first, dimension).norm() >= (1.0 - 1e-9) * limit;
    state.tangents.set_stick(contact, !slides && !gives_way);
    laws.set_at_limit(contact, false);
    if (slides)
      laws.set_slip_direction(contact, (1.0 / norm(towards)) * towards);
    else if (gives_way && norm(against) > 0.0)
      laws.set_slip_direction(contact, (1.0 / norm(against)) * against);
  }
}

/// Returns true if pivoting decides. On curves where friction changes no reaction, pivoting finds exactly the contacts
/// that give way in the middle of a run.
bool is_left_to_search(const ContactState& state, const ModeSwitch& at, const ContactChoice& choice) {
  const bool shares = !std::isnan(choice.load);
  const bool is_overloaded = std::any_of(choice.members.begin(), choice.members.end(),
                                         [&](std::size_t contact) { return state.overloads[contact] != 0; });
  if (!shares && !is_overloaded) return true;
  return !at.is_start() && choice.keeps_reactions();
}

void take_one(ContactState& state, const ModeSwitch& at, ContactChoice* choice) {
  constexpr int steps = ContactState::softness_steps;
  FrictionLaws& laws = state.laws;
  const bool shares = !std::isnan(choice->load);
  for (std::size_t c = 0; c < choice->size(); ++c) {
    const std::size_t contact = choice->members[c];
    const bool moves = choice->problem.contacts[c].moves, sticks = choice->sticks[c] != 0;
    const Vec3 given = choice->combine(c, choice->x), shared = choice->combine(c, choice->share);
    if (!moves && !sticks && norm(given) > 0.0) laws.set_slip_direction(contact, (-1.0 / norm(given)) * given);
    laws.set_reference(contact, sticks ? shared : Vec3{});
    const double bits = shares ? -steps * std::log2(choice->weights(static_cast<Eigen::Index>(c))) : 0.0;
    state.softness[contact] = static_cast<int>(std::lround(std::clamp(bits, 0.0, 10.0 * steps)));
    const double limit = choice->limit(c, choice->share);
    state.overloads[contact] = sticks && norm(shared) > (1.0 - ContactState::to_spare) * limit;
    if (at.at_rest[contact] != 0) state.tangents.set_stick(contact, sticks);
  }
  choice->has_shared = true;
}

}  // namespace

Outcome count_motions(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                      const std::vector<char>& wanted, std::size_t most_contacts, bool takes_all,
                      std::vector<ContactChoice>* choices) {
  friction.set_place(state.place(at.t, at.r, at.v));
  std::vector<ContactChoice> counted = list_islands(state, friction, at, wanted, most_contacts);
  if (counted.empty()) return {};
  Outcome outcome =
      with_reduced(state, friction, at, &counted, [&] { return choose_all(state, friction, at, &counted); });
  if (outcome.ok()) {
    for (const ContactChoice& choice : counted) {
      if (choice.has_solution()) set_modes(state, at, choice);
    }
    outcome = take_choices(state, at, takes_all, &counted);
  }
  if (takes_all) std::erase_if(counted, [](const auto& choice) { return !choice.has_shared; });
  std::ranges::move(counted, std::back_inserter(*choices));
  return outcome;
}

Outcome take_choices(ContactState& state, const ModeSwitch& at, bool all, std::vector<ContactChoice>* choices) {
  bool has_taken = false;
  for (ContactChoice& choice : *choices) {
    if (!choice.has_solution() || (!all && is_left_to_search(state, at, choice))) continue;
    take_one(state, at, &choice);
    has_taken = true;
  }
  if (!has_taken) return {};
  state.forget_shares();
  return state.system.linearise(at.t, at.r);
}

Outcome verify_uncounted(ContactState& state, FrictionSolver& friction, const ModeSwitch& at,
                         const std::vector<char>& wanted) {
  constexpr std::size_t most_reduced = 256;  // each of their components costs one solve
  if (std::none_of(wanted.begin(), wanted.end(), [](char is) { return is != 0; })) return {};
  friction.set_place(state.place(at.t, at.r, at.v));
  std::vector<ContactChoice> choices =
      list_islands(state, friction, at, wanted, std::numeric_limits<std::size_t>::max());
  std::erase_if(choices, [&](const ContactChoice& choice) {
    const bool are_too_many = choice.size() > most_reduced;
    if (are_too_many) state.verdict.note(Uniqueness::Unproven, too_many);
    return are_too_many;
  });
  if (choices.empty()) return {};
  const Outcome reduced = with_reduced(state, friction, at, &choices, [&]() -> Outcome {
    for (ContactChoice& choice : choices) {
      for (std::size_t c = 0; c < choice.size(); ++c)
        choice.problem.contacts[c].mu = state.laws.static_coefficient(choice.members[c]);
      const bool is_proven = is_proven_unique(choice.problem);
      state.verdict.note(is_proven ? Uniqueness::Proven : Uniqueness::Unproven, is_proven ? "" : too_many);
    }
    return {};
  });
  if (!reduced.ok()) state.verdict.note(Uniqueness::Unproven, too_many);
  return state.system.linearise(at.t, at.r);
}

}  // namespace tanor::detail
