#include "contact/rough_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "friction/contact_problem.hpp"

namespace tanor::detail {

namespace {

constexpr double largest_error = 1e-9;  // of an impact, see error_of_contacts()

}  // namespace

RoughRows::RoughRows(Workspace& work, ConstrainedSystem& system, Gaps& gaps, Contacts* contacts)
    : work_(work),
      model_(work.model()),
      system_(system),
      gaps_(gaps),
      contacts_(contacts),
      islands_(work, system, gaps.arms()) {}

std::vector<char> RoughRows::rows_of(const std::function<bool(std::size_t)>& takes_part) const {
  std::vector<char> rows(gaps_.closed().size(), 0);
  for (std::size_t island = 0; island < islands_.size(); ++island) {
    if (!takes_part(island)) continue;
    for (const std::size_t k : islands_.rows(island)) rows[k] = 1;
  }
  return rows;
}

void RoughRows::begin(const OneSidedInstant& at, std::span<const std::size_t> met) {
  if (empty()) return;
  const Tangents& tangents = work_.constraints.tangents();
  met_.assign(met.begin(), met.end());
  jams_.clear();
  uniqueness_ = Uniqueness::NotAsked;
  reason_.clear();
  stuck_.resize(tangents.size());
  for (std::size_t c = 0; c < tangents.size(); ++c) stuck_[c] = tangents.sticks(c) ? 1 : 0;
  was_stuck_ = stuck_;
  if (at.begins) std::ranges::fill(stuck_, 0);  // velocities tell
  stops_.assign(tangents.size(), 0);
  guides_.assign(tangents.size(), GuideChange::None);
  lambda_before_ = system_.lambda();
  tau_before_.assign(3 * tangents.size(), 0.0);
  if (!at.begins) contacts_->write_contacts(lambda_before_.data(), &tau_before_);
  has_changed_.assign(islands_.size(), at.begins ? 1 : 0);
  for (std::size_t k = 0; k < at.touches.size(); ++k) {
    const bool changes = at.leaves[k] != 0 || (at.touches[k] != 0 && gaps_.closed()[k] == 0);
    if (have(k) && changes) has_changed_[islands_.island_of(k)] = 1;
  }
  std::size_t event = 0;
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (tangents[c].first_row < 0 || std::ranges::find(met_, event++) == met_.end()) continue;
    has_changed_[islands_.island_of_contact(c)] = 1;
    stops_[c] = stuck_[c] == 0;
  }
}

/// Reduces the rows that take part, which are open afterwards.
Outcome RoughRows::reduce(const OneSidedInstant& at, const std::vector<char>& take_part,
                          std::vector<RoughProblem>* problems) {
  for (const bool is_closed : {true, false}) {
    for (std::size_t k = 0; k < take_part.size(); ++k)
      if (take_part[k] != 0) gaps_.closed()[k] = is_closed ? 1 : 0;
    gaps_.apply();
    if (is_closed) islands_.measure(at.r, at.v, take_part);
  }
  if (Outcome outcome = system_.linearise(at.t, at.r); !outcome.ok()) return outcome;
  *problems = islands_.reduce();
  return {};
}

// ---- impacts ----

/// Solves an impact of some rows, whose velocities it changes. Those that rest afterwards are closed.
Outcome RoughRows::strike(OneSidedInstant* at, const std::vector<char>& take_part, const std::vector<double>& rates,
                          ContactChange change, const Solve& solve) {
  std::vector<RoughProblem> problems;
  if (Outcome outcome = reduce(*at, take_part, &problems); !outcome.ok()) return outcome;
  islands_.set_velocities(at->r, at->v, &problems);
  std::vector<Eigen::VectorXd> P;
  for (const RoughProblem& problem : problems) {
    const RoughImpact impact = solve(problem);
    if (!(impact.error <= largest_error) || !impact.P.allFinite()) {
      return {Status::NotConverged, "the impact at t = " + text(at->t) + " at " +
                                        equation_name(model_.system, gaps_.user_row(problem.contacts.front().row)) +
                                        ": its impulses are not found (error " + text(impact.error) + ")"};
    }
    const Eigen::VectorXd after = problem.q + problem.W * impact.P;
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const RoughContact& contact = problem.contacts[c];
      const double speed = Gaps::resting * gaps_.speed(contact.row) / contact.gradient;
      gaps_.closed()[contact.row] = std::abs(problem.normal(c, after)) <= speed ? 1 : 0;
      if (problem.normal(c, problem.q) < -speed) at->leaves[contact.row] = 0;
    }
    for (const std::size_t k : islands_.rows(problem.island))
      if (islands_.contact_of(k) != RoughContact::none) guides_[islands_.contact_of(k)] = GuideChange::Struck;
    has_changed_[problem.island] = 1;
    note_impact(at, problem, impact, rates, change);
    P.push_back(impact.P);
  }
  const std::vector<double> lambda = islands_.strike(problems, P, at->v);
  // K'v + xi_t of what is prescribed alone
  std::vector<double> prescribed(at->v, at->v + 3 * model_.num_points()), own(model_.num_rows(), 0.0);
  std::fill_n(prescribed.begin(), 3 * model_.num_moving(), 0.0);
  (void)work_.constraints.evaluate_rates(model_.parallel, at->r, prescribed.data(), own.data());
  (void)work_.constraints.evaluate_rates(model_.parallel, work_.constraints.select(model_.numbering.may_open), at->r,
                                         prescribed.data(), own.data());
  for (std::size_t p = 0; p < problems.size(); ++p)
    add_work_of_guides(at, problems[p], P[p], lambda, own, &at->changes[at->changes.size() - problems.size() + p]);
  return {};
}

/// Notes an impact, those that approach first, then others that take part.
void RoughRows::note_impact(OneSidedInstant* at, const RoughProblem& problem, const RoughImpact& impact,
                            const std::vector<double>& rates, ContactChange change) const {
  ContactEvent event{.time = at->t, .change = change, .energy_lost = -impact.energy_change};
  for (const bool first : {true, false}) {
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const RoughContact& contact = problem.contacts[c];
      const std::size_t k = contact.row;
      const double P = problem.normal(c, impact.P), least = Gaps::resting * gaps_.speed(k) / contact.gradient;
      const bool approaches = problem.normal(c, problem.q)<-least, is_pressed = P * problem.W(3 * c, 3 * c)> least;
      if (approaches != first || (!first && !is_pressed)) continue;
      event.equations.push_back(gaps_.user_row(k));
      event.impulses.push_back(std::max(0.0, P / contact.gradient));
      event.rates_before.push_back(-rates[k]);
    }
  }
  event.restitution_capped = impact.is_capped;
  if (change == ContactChange::Touch && !event.equations.empty()) {
    for (const RoughContact& contact : problem.contacts)
      if (gaps_.user_row(contact.row) == event.equations.front()) event.change = gaps_.name_change(contact.row, true);
  }
  at->work.impacts += impact.energy_change;
  at->changes.push_back(std::move(event));
}

/// Adds the work of what moves by itself against impulses: lambda [rows] of the rows that took no part, and P.
void RoughRows::add_work_of_guides(OneSidedInstant* at, const RoughProblem& problem, const Eigen::VectorXd& P,
                                   const std::vector<double>& lambda, const std::vector<double>& own,
                                   ContactEvent* event) const {
  const Tangents& tangents = work_.constraints.tangents();
  const std::vector<Index>& start = model_.numbering.island_start;
  double supports = 0.0, belts = 0.0;
  const Index row = model_.numbering.one_sided[problem.contacts.front().row].row;
  const std::size_t island = model_.numbering.island_of(row);
  for (auto a = static_cast<std::size_t>(start[island]); a < static_cast<std::size_t>(start[island + 1]); ++a)
    if (!model_.numbering.comes_and_goes(a)) supports -= lambda[a] * own[a];
  for (std::size_t c = 0; c < problem.size(); ++c) {
    const RoughContact& contact = problem.contacts[c];
    const OneSidedRow& one_sided = model_.numbering.one_sided[contact.row];
    supports -= one_sided.sign * problem.normal(c, P) / contact.gradient * own[static_cast<std::size_t>(one_sided.row)];
    if (!contact.has_friction()) continue;
    const Vec3 u = tangents.own_velocity(contact.contact).value;
    const Eigen::Vector2d tangential = problem.tangential(c, P);
    belts += tangential(0) * dot(contact.tangents[0], u) + tangential(1) * dot(contact.tangents[1], u);
  }
  at->work.supports += supports;
  at->work.friction += belts;
  event->energy_lost -= supports + belts;
}

Outcome RoughRows::collide(OneSidedInstant* at, const std::vector<double>& rates, bool* collides) {
  *collides = false;
  if (empty()) return {};
  std::vector<char> approach(islands_.size(), 0), take_part(rates.size(), 0);
  const auto limit = [&](std::size_t k) { return Gaps::resting * gaps_.speed(k); };
  for (std::size_t k = 0; k < rates.size(); ++k) {
    if (!have(k) || at->touches[k] == 0 || !(rates[k] < -gaps_.slowest(k, at->impacts == 0 && at->falls[k] != 0)))
      continue;
    *collides = true;
    approach[islands_.island_of(k)] = 1;
  }
  if (!*collides) return {};
  for (std::size_t k = 0; k < rates.size(); ++k) {
    if (!have(k) || approach[islands_.island_of(k)] == 0) continue;
    gaps_.closed()[k] = 0;
    take_part[k] = at->touches[k] != 0 && rates[k] <= limit(k);
  }
  return strike(at, take_part, rates, ContactChange::Touch, [&](const RoughProblem& problem) {
    Eigen::VectorXd restitution = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(problem.size()));
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const std::size_t k = problem.contacts[c].row;
      if (rates[k] < -limit(k)) restitution(static_cast<Eigen::Index>(c)) = gaps_.restitution(k);
    }
    return solve_impact(problem, restitution);
  });
}

Outcome RoughRows::end_jams(OneSidedInstant* at) {
  std::vector<double> rates;
  gaps_.measure_rates(at->r, at->v, &rates);
  std::vector<char> take_part =
      rows_of([&](std::size_t island) { return std::ranges::find(jams_, island) != jams_.end(); });
  for (std::size_t k = 0; k < take_part.size(); ++k) {
    const bool rests = at->touches[k] != 0 && std::abs(rates[k]) <= Gaps::resting * gaps_.speed(k);
    take_part[k] = take_part[k] != 0 && rests;
  }
  jams_.clear();
  bool has_ended = true;
  Outcome outcome = strike(at, take_part, rates, ContactChange::Jam, [&](const RoughProblem& problem) {
    RoughImpact impact = solve_jam(problem);
    const double changed = (problem.W * impact.P).lpNorm<Eigen::Infinity>();
    has_ended = has_ended && changed > 1e-6 * problem.q.lpNorm<Eigen::Infinity>();
    return impact;
  });
  if (outcome.ok() && !has_ended) {
    const std::size_t row = at->changes.back().equations.empty() ? 0 : at->changes.back().equations.front();
    outcome =
        fail_friction(Status::NoSolution, at->t,
                      equation_name(model_.system, row) +
                          ": no accelerations obey the law (all modes of open, stick and slip were tried), and no "
                          "impulse ends the slide");
  }
  return outcome;
}

Outcome RoughRows::end_slow_flights(OneSidedInstant* at, const std::vector<double>& rates) {
  if (empty()) return {};
  std::vector<char> take_part = rows_of([&](std::size_t island) {
    return std::ranges::any_of(islands_.rows(island), [&](std::size_t k) {
      return gaps_.closed()[k] != 0 && rates[k] > Gaps::resting * gaps_.speed(k);
    });
  });
  for (std::size_t k = 0; k < take_part.size(); ++k) take_part[k] = take_part[k] != 0 && gaps_.closed()[k] != 0;
  if (std::ranges::none_of(take_part, [](char each) { return each != 0; })) return {};
  const std::size_t count = at->changes.size();
  Outcome outcome = strike(at, take_part, rates, ContactChange::Zeno, [&](const RoughProblem& problem) {
    return solve_slow_flight(problem, Gaps::resting * gaps_.speed(problem.contacts.front().row));
  });
  at->changes.resize(std::min(count, at->changes.size()));  // the caller names them
  return outcome;
}

// ---- one instant ----

void RoughRows::note(Uniqueness uniqueness, const std::string& why) {
  if (uniqueness <= uniqueness_) return;
  uniqueness_ = uniqueness;
  reason_ = why;
}

Outcome RoughRows::choose_closed(OneSidedInstant* at, const std::vector<char>& may_close,
                                 std::vector<char>* are_known) {
  are_known->assign(may_close.size(), 0);
  if (empty()) return {};
  std::vector<char> take_part = rows_of([&](std::size_t island) { return has_changed_[island] != 0; });
  for (std::size_t k = 0; k < may_close.size(); ++k) {
    (*are_known)[k] = have(k) && take_part[k] == 0 ? 1 : 0;
    take_part[k] = take_part[k] != 0 && may_close[k] != 0;
  }
  const std::vector<char> closed = gaps_.closed();
  std::vector<RoughProblem> problems;
  if (Outcome outcome = reduce(*at, take_part, &problems); !outcome.ok()) return outcome;
  gaps_.closed() = closed;
  std::vector<RoughProblem> moving = problems;
  islands_.set_velocities(at->r, at->v, &moving);
  islands_.set_accelerations(at->t, at->r, at->v, &problems);
  for (std::size_t p = 0; p < problems.size(); ++p) {
    const RoughProblem& problem = problems[p];
    std::vector<double> rest;
    for (std::size_t c = 0; c < problem.size(); ++c) {
      const RoughContact& contact = problem.contacts[c];
      rest.push_back(Gaps::resting * gaps_.speed(contact.row));
      if (!contact.has_friction()) continue;
      const bool is_struck = guides_[contact.contact] == GuideChange::Struck;
      const bool stops = !met_.empty() && stops_[contact.contact] != 0;
      if (!is_struck && (stops || stuck_[contact.contact] != 0)) rest.back() = std::numeric_limits<double>::max();
    }
    RoughMotions motions = find_motions(problem, moving[p].q, rest, most_work(at->begins), at->begins);
    if (motions.uniqueness == Uniqueness::None) {
      jams_.push_back(problem.island);
      continue;
    }
    if (motions.uniqueness == Uniqueness::Several && at->begins) return explain(*at, problem, motions);
    note(motions.uniqueness, motions.uniqueness == Uniqueness::Several
                                 ? "several accelerations obeyed the law at t = " + text(at->t)
                                 : motions.reason);
    if (motions.found.empty()) continue;
    const Eigen::VectorXd before = islands_.forces(problem, lambda_before_.data(), tau_before_);
    const auto distance = [&](const RoughMotion& motion) {
      const Eigen::VectorXd change = motion.r - before;
      return change.dot(problem.W * change);
    };
    const auto nearest = std::ranges::min_element(motions.found, {}, distance);
    for (std::size_t c = 0; c < problem.size(); ++c) {
      gaps_.closed()[problem.contacts[c].row] = nearest->is_closed[c];
      (*are_known)[problem.contacts[c].row] = 1;
    }
  }
  return {};
}

Outcome RoughRows::explain(const OneSidedInstant& at, const RoughProblem& problem, const RoughMotions& motions) const {
  // Find the contact whose accelerations differ most.
  std::vector<Eigen::VectorXd> accelerations;
  for (const RoughMotion& motion : motions.found) accelerations.push_back(problem.q + problem.W * motion.r);
  std::size_t worst = 0;
  double most = -1.0;
  for (std::size_t c = 0; c < problem.size(); ++c) {
    const auto first = 3 * static_cast<Eigen::Index>(c);
    const double apart = (accelerations[0] - accelerations[1]).segment<3>(first).norm();
    if (!problem.contacts[c].has_friction() || apart <= most) continue;
    most = apart;
    worst = c;
  }
  std::string list;
  const Units& units = model_.system.units;
  for (std::size_t k = 0; k < motions.found.size(); ++k) {
    const double away = problem.normal(worst, accelerations[k]), N = problem.normal(worst, motions.found[k].r);
    list += std::string(k == 0 ? "" : k + 1 == motions.found.size() ? ", or " : ", ");
    list += motions.found[k].is_closed[worst] == 0
                ? "it lifts off with the acceleration " + with_unit(text(away), units.letters(Dimension::Acceleration))
                : "it presses with " + with_unit(text(N), units.force) + " and slides by " +
                      with_unit(text(problem.tangential(worst, accelerations[k]).norm()),
                                units.letters(Dimension::Acceleration));
  }
  return fail_friction(Status::NotUnique, at.t,
                       work_.name_contact(problem.contacts[worst].contact) + ": " + text(motions.found.size()) +
                           " motions obey the law: " + list + "; at a start nothing says which");
}

Outcome RoughRows::choose_modes(OneSidedInstant* at) {
  Tangents& tangents = work_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c)
    if (!tangents.is_open(c)) tangents.set_stick(c, stuck_[c] != 0);
  if (Outcome outcome = system_.linearise(at->t, at->r); !outcome.ok()) return outcome;
  for (std::size_t c = 0; c < tangents.size(); ++c)
    if (has_changed_[islands_.island_of_contact(c)] != 0) guides_[c] = std::max(guides_[c], GuideChange::Island);
  Outcome outcome;
  if (at->begins) {
    outcome = contacts_->begin(at->t, at->r, at->v, at->request, at->to);
    contacts_->note(uniqueness_, reason_);
  } else {
    contacts_->note(uniqueness_, reason_);
    outcome = contacts_->switch_guides(at->t, at->r, at->v, met_, guides_, at->request, at->to);
  }
  at->work.add(1.0, contacts_->events()->work_of_switch());
  if (SolveReport* const report = at->to.report; report != nullptr && uniqueness_ > report->friction.uniqueness) {
    report->friction.uniqueness = uniqueness_;
    report->friction.uniqueness_reason = reason_;
  }
  if (outcome.status == Status::NoSolution && uniqueness_ == Uniqueness::Unproven) {
    // Other contacts may be the closed ones.
    outcome = {Status::NotConverged,
               "which contacts are open, stick or slide at t = " + text(at->t) + " is not found: " + reason_};
  }
  if (!outcome.ok()) return outcome;
  met_.clear();
  std::ranges::fill(guides_, GuideChange::None);
  for (std::size_t c = 0; c < tangents.size(); ++c) stuck_[c] = tangents.sticks(c) ? 1 : 0;
  return outcome;
}

void RoughRows::note_modes(OneSidedInstant* at, const std::vector<char>& was_closed) const {
  if (empty() || !at->is_listed) return;
  const Tangents& tangents = work_.constraints.tangents();
  for (std::size_t k = 0; k < was_closed.size(); ++k) {
    const std::size_t c = islands_.contact_of(k);
    if (c == RoughContact::none || was_closed[k] == 0 || gaps_.closed()[k] == 0) continue;
    const bool sticks = tangents.sticks(c), stuck = was_stuck_[c] != 0;
    if (sticks != stuck || (stops_[c] != 0 && !sticks))
      at->changes.push_back({.time = at->t,
                             .change = sticks ? ContactChange::Stick : ContactChange::Slip,
                             .equations = {gaps_.user_row(k)}});
  }
}

}  // namespace tanor::detail
