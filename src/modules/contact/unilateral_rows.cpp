#include "contact/unilateral_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <type_traits>
#include <utility>
#include <variant>

#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "contact/exchange.hpp"
#include "system/members.hpp"

namespace tanor::detail {

namespace {

// Thresholds, over the length L, the speed V and the acceleration V^2/L of the row's own neighbourhood.

constexpr double touching = 1e-12;           // Gaps that close together differ by no more.
constexpr double touching_at_start = 1e-10;  // Given positions are rounded.
constexpr double zeno = 1e-4;                // Slower bounces are the last ones; the state is wrong by their cube.
constexpr double unseen = 1e-7;              // Slower flights rise by less than rounding.
/// Falling forces and gaps end a mode this far below 0, so that the rounding of one that rests there does not.
constexpr double slack_of_forces = 1e-13, slack_of_gaps = 1e-14;

/// The JSON pointer of an equation with one row a member, and its number in words, "; its length is 0.9 m".
struct MemberPlace {
  std::string pointer, number;
};
MemberPlace place_of(const System& system, std::size_t row, double t) {
  MemberPlace place;
  for (std::size_t g = 0; g < system.constraints.size() && place.pointer.empty(); ++g) {
    const auto [members, rows] = shape_of(system.constraints[g]);
    if (row >= members * rows) {
      row -= members * rows;
      continue;
    }
    std::visit(
        [&]<class Group>(const Group& group) {
          place.pointer = "/constraints/" + text(g) + "/" + list_name<Group>() + "/" + text(row);
          for_each_field<Group>([&]<class Value>(const FieldOf<Group, Value>& field) {
            if constexpr (std::is_same_v<Value, Parameter>) {
              const Parameter& given = group.*field.value;
              if (!given.is_initial())
                place.number = "; its " + std::string(field.name) + " is " +
                               with_unit(text(number_of(given, row, 0.0)(t).value()), field.data.unit);
            }
          });
        },
        system.constraints[g]);
  }
  return place;
}

}  // namespace

UnilateralRows::UnilateralRows(Workspace& work, ConstrainedSystem& system, Contacts* contacts)
    : Gaps(work, system),
      friction_(work, system, *this, contacts),
      dependent_(model_, system, *this),
      slack_(rows_.size(), 0.0) {
  std::vector<double> r(3 * model_.num_points());
  model_.numbering.gather_points(model_.system.positions, r);
  (void)close_touching(work.time(), r.data(), StartMode::Project);
}

std::unique_ptr<Unilateral> make_unilateral(Workspace& work, ConstrainedSystem& system, Contacts* contacts) {
  return std::make_unique<UnilateralRows>(work, system, contacts);
}

// ---- measures ----

/// Replaces multipliers by those of least norm where closed rows depend on others, since these alone show which rows
/// pull the wrong way. Friction belongs to those of its own island, which stay.
void UnilateralRows::minimize_norm(const double* r, std::vector<double>* lambda) {
  if (!dependent_.have(smooth(closed_))) return;
  const std::vector<double> given = *lambda;
  system_.minimize_multiplier_norm(r, lambda->data());
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const auto row = static_cast<std::size_t>(rows_[k].row);
    if (friction_.have(k)) (*lambda)[row] = given[row];
  }
}

/// Returns those of `rows` [one-sided row] that lie in islands without friction.
std::vector<char> UnilateralRows::smooth(std::vector<char> rows) const {
  for (std::size_t k = 0; k < rows_.size(); ++k)
    if (friction_.have(k)) rows[k] = 0;
  return rows;
}

/// Open gaps that rest at 0, or are below it by rounding, get a slack; others reach 0 where they do.
void UnilateralRows::measure_slack(const Instant& at) {
  constexpr double rounding = 32.0 * std::numeric_limits<double>::epsilon();
  measure_rates(at.r, at.v, &rates_);
  measure_gaps(at.t, at.r);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    slack_[k] = 0.0;
    if (at.touches[k] == 0 || closed_[k] != 0) continue;
    double far = 0.0;
    for (const Incidence& arm : arms_[k]) far = std::max(far, norm(load(at.r, arm.point)));
    const bool rests = rates_[k] <= resting * speed(k);
    slack_[k] = std::max(0.0, -gaps_[k]) + (rests ? std::max(rounding * far, slack_of_gaps * length(k)) : eps * far);
  }
}

// ---- events ----

/// The value of an open row is its gap, that of a closed one its force, each with its slack.
void UnilateralRows::evaluate_events(const Kinematics& at, const Reactions& found, double* values) {
  measure_gaps(at.t, at.x);
  forces_ = found.lambda;
  minimize_norm(at.x, &forces_);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (closed_[k] == 0) {
      values[k] = gaps_[k] + slack_[k];
    } else {
      const double slack = slack_of_forces * acceleration(k) / inverse_effective_mass(k);
      values[k] = rows_[k].sign * forces_[static_cast<std::size_t>(rows_[k].row)] + slack;
    }
  }
  if (!friction_.empty()) friction_.modes()->evaluate_events(at, found, values + rows_.size());
}

void UnilateralRows::shape_events(const Reactions& found, const double* values, double* shapes) const {
  std::copy_n(values, rows_.size(), shapes);
  if (!friction_.empty()) friction_.modes()->shape_events(found, values + rows_.size(), shapes + rows_.size());
}

void UnilateralRows::evaluate_slopes(const Kinematics& at, std::span<double> slopes) {
  measure_rates(at.x, at.v, &rates_);
  std::ranges::fill(slopes, unknown_slope);
  for (std::size_t k = 0; k < rows_.size(); ++k) slopes[k] = closed_[k] == 0 ? rates_[k] : unknown_slope;
}

std::vector<int> UnilateralRows::discrete_state() const {
  std::vector<int> state(closed_.begin(), closed_.end());
  if (friction_.empty()) return state;
  const std::vector<int> modes = friction_.modes()->discrete_state();
  state.insert(state.end(), modes.begin(), modes.end());
  return state;
}

std::string UnilateralRows::describe_change(std::span<const int> before) const {
  std::string change;
  for (std::size_t k = 0; k < std::min(rows_.size(), before.size()); ++k) {
    if (before[k] == closed_[k]) continue;
    if (!change.empty()) return change + ", and others";
    change = workspace_.name_row(static_cast<std::size_t>(rows_[k].row)) + (closed_[k] != 0 ? " closes" : " opens");
  }
  if (change.empty() && !friction_.empty())
    return friction_.modes()->describe_change(before.subspan(std::min(rows_.size(), before.size())));
  return change;
}

void UnilateralRows::restore_discrete_state(std::span<const int> state) {
  const std::span<const int> modes = state.subspan(std::min(rows_.size(), state.size()));
  state = state.first(state.size() - modes.size());
  if (state.size() != rows_.size() || (friction_.empty() && !modes.empty()))
    throw InputError("/snapshot/discrete_state", text(state.size() + modes.size()) + " modes for " +
                                                     text_of_count(rows_.size(), "one-sided equation"));
  std::ranges::transform(state, closed_.begin(), [](int each) { return static_cast<char>(each != 0); });
  continues_ = true;
  apply();
  if (!friction_.empty()) friction_.modes()->restore_discrete_state(modes);
}

// ---- starts ----

bool UnilateralRows::close_touching(double t, const double* r, StartMode mode) {
  constexpr double allowed = 1e-3;
  bool is_broken = false;
  measure_gaps(t, r);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const char before = std::exchange(closed_[k], gaps_[k] <= touching_at_start * length(k));
    is_broken = is_broken || (before == 0 && gaps_[k] < -touching_at_start * length(k));
    if (mode == StartMode::Project || gaps_[k] >= -allowed * length(k)) continue;
    const std::string gap = with_unit(text(-gaps_[k]), model_.system.units.length);
    const MemberPlace place = place_of(model_.system, user_row(k), t);
    throw InputError(place.pointer, equation_name(model_.system, user_row(k)) + " begins " + gap + " beyond its side" +
                                        place.number + " (\"start\": \"project\" finds the nearest admissible start)");
  }
  apply();
  return is_broken;
}

void UnilateralRows::open_moving(double t, const double* r, const double* v) {
  workspace_.set_time(t);
  measure_rates(r, v, &rates_);
  for (std::size_t k = 0; k < rows_.size(); ++k)
    closed_[k] = closed_[k] != 0 && std::abs(rates_[k]) <= resting * speed(k);
  apply();
}

/// Finds the rows whose gaps are 0, to `limit` of the length around each, or which are closed and are to be kept.
UnilateralRows::Instant UnilateralRows::look(const Kinematics& place, double* v, const Request& request,
                                             const AccelerationOutput& to, double limit, bool keeps_closed) {
  Instant at{place.t, place.x, v, request, to};
  measure_gaps(at.t, at.r);
  at.leaves.assign(rows_.size(), 0);
  at.falls = at.leaves;
  for (std::size_t k = 0; k < rows_.size(); ++k)
    at.touches.push_back(gaps_[k] <= limit * length(k) || (keeps_closed && closed_[k] != 0));
  return at;
}

Outcome UnilateralRows::begin(double t, const double* r, double* v, const Request& request,
                              const AccelerationOutput& to) {
  const bool continues = std::exchange(continues_, false);
  Instant at = look({t, r, v}, v, request, to, touching_at_start, continues);
  at.begins = true;
  at.is_listed = continues;
  friction_.begin(at, {});
  return choose(std::move(at));
}

Outcome UnilateralRows::switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                                         const Request& request, const AccelerationOutput& to) {
  Instant at = look({t, r, v}, v, request, to, touching, true);
  std::vector<std::size_t> met;
  for (const std::size_t k : which) {
    if (k >= rows_.size()) {
      met.push_back(k - rows_.size());
      continue;
    }
    at.touches[k] = 1;
    at.leaves[k] = closed_[k];
    at.falls[k] = closed_[k] == 0;
  }
  friction_.begin(at, met);
  return choose(std::move(at));
}

// ---- the driver ----

/// Solves impacts until no gap closes, then chooses the rows that stay closed.
Outcome UnilateralRows::choose(Instant at) {
  constexpr int most_jams = 4;
  workspace_.set_time(at.t);
  const std::vector<char> before = closed_;
  Outcome outcome = collide_all(&at);
  bool has_slow = true;
  int jams = 0;
  for (std::size_t pass = 0; outcome.ok() && has_slow && pass <= rows_.size(); ++pass) {  // each closes one or more
    outcome = find_closed(&at);
    for (; outcome.ok() && friction_.are_jammed() && jams < most_jams; ++jams) {
      outcome = friction_.end_jams(&at);
      if (outcome.ok()) outcome = collide_all(&at);
      if (outcome.ok()) outcome = find_closed(&at);
    }
    if (outcome.ok() && friction_.are_jammed())
      outcome = {Status::NoSolution, "jams follow one another without end at t = " + text(at.t)};
    if (outcome.ok()) outcome = end_slow_flights(&at, &has_slow);
  }
  if (outcome.ok() && has_slow) outcome = {Status::NotConverged, "slow flights do not end at t = " + text(at.t)};
  if (!outcome.ok()) return outcome;
  std::set<std::size_t> told;
  for (const ContactEvent& change : at.changes) told.insert(change.equations.begin(), change.equations.end());
  for (std::size_t k = 0; k < rows_.size() && at.is_listed; ++k) {
    const bool closes = before[k] == 0 && closed_[k] != 0,
               opens = closed_[k] == 0 && (at.leaves[k] != 0 || before[k] != 0);
    if ((closes || opens) && !told.contains(user_row(k)))
      at.changes.push_back({.time = at.t, .change = name_change(k, closes), .equations = {user_row(k)}});
  }
  friction_.note_modes(&at, before);
  measure_slack(at);
  impact_work_ = at.work;
  changes_ = std::move(at.changes);
  return {};
}

Outcome UnilateralRows::collide_all(Instant* at) {
  const int allowed = model_.max_impacts_at_one_instant;
  for (bool collides = false;; ++at->impacts) {
    if (Outcome outcome = collide(at, &collides); !outcome.ok() || !collides) return outcome;
    if (at->impacts == allowed)
      return {Status::NotConverged, "more impacts follow one another at t = " + text(at->t) +
                                        " than solver.contact.max_at_one_instant allows, " + text(allowed) +
                                        ", the last one at " +
                                        equation_name(model_.system, at->changes.back().equations.front())};
  }
}

/// Closes rows without friction. In islands with friction RoughRows chooses.
void UnilateralRows::close_smooth(const std::vector<char>& closed) {
  for (std::size_t k = 0; k < rows_.size(); ++k)
    if (!friction_.have(k)) closed_[k] = closed[k];
  apply();
}

/// Closes rows as `dependent_` chooses them, to which free() gives what they do where all of them are open. Looks ahead
/// then, if it can.
template <class Free, class Solve>
Outcome UnilateralRows::close_dependent(const Instant& at, const std::vector<char>& may_close, const Free& free,
                                        const Solve& solve) {
  close_smooth(std::vector<char>(rows_.size(), 0));
  if (Outcome outcome = free(); !outcome.ok()) return outcome;
  for (const bool looks_ahead : {false, true}) {
    if (looks_ahead && !(solve().ok() && dependent_.look_ahead(at.r, at.v, at.to.a, may_close))) return {};
    close_smooth(may_close);
    if (Outcome outcome = system_.linearise(at.t, at.r); !outcome.ok()) return outcome;
    close_smooth(dependent_.choose(may_close));
  }
  return {};
}

/// Exchanges rows that may close between closed and open until none is wrong. Where rows without friction depend on
/// others, it begins with those of a compliant S.
template <class Free, class Solve, class IsWrong>
Outcome UnilateralRows::pivot(const Instant& at, const std::vector<char>& may_close, const Free& free,
                              const Solve& solve, const IsWrong& is_wrong) {
  const std::vector<char> may_depend = smooth(may_close);
  Exchange exchange;
  for (bool is_first = true; !exchange.is_stuck(); is_first = false) {
    apply();
    Outcome outcome = solve();
    if (is_first && dependent_.have(may_depend)) {
      if (Outcome found = close_dependent(at, may_depend, free, solve); !found.ok()) return found;
      continue;
    }
    if (!outcome.ok()) return outcome;
    std::vector<std::size_t> wrong;
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      if (closed_[k] != 0 && !(inverse_effective_mass(k) > 0.0))
        return {Status::Singular,
                "the gradient of " + equation_name(model_.system, user_row(k)) + " vanishes at t = " + text(at.t)};
      if (may_close[k] != 0 && is_wrong(k)) wrong.push_back(k);
    }
    if (wrong.empty()) return {};
    for (const std::size_t k : exchange.choose(wrong, {closed_.begin(), closed_.end()})) closed_[k] = closed_[k] == 0;
  }
  return {Status::NotConverged, "which one-sided constraints are closed at t = " + text(at.t) + " is not found"};
}

// ---- impacts ----

/// Solves S x = -(1 + e) u for the rows that touch and do not separate, then v += M^-1 K x, P = s x.
Outcome UnilateralRows::collide(Instant* at, bool* collides) {
  std::vector<double> rates, after, restitution(rows_.size(), 0.0), b(model_.num_rows()), x(model_.num_rows()), dw;
  std::vector<char> may_close(rows_.size()), approaches(rows_.size());
  measure_rates(at->r, at->v, &rates);
  if (Outcome outcome = friction_.collide(at, rates, collides); !outcome.ok() || *collides) return outcome;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    may_close[k] = at->touches[k] != 0 && rates[k] <= resting * speed(k);
    approaches[k] = at->touches[k] != 0 && rates[k] < -slowest(k, at->impacts == 0 && at->falls[k] != 0);
    if (approaches[k] == 0) continue;
    *collides = true;
    restitution[k] = rows_[k].restitution;
  }
  if (!*collides) return {};

  const std::size_t size = 3 * model_.num_points();
  std::vector<double> v(size);
  dw.resize(size);
  closed_ = may_close;
  const auto free = [&]() -> Outcome {
    std::ranges::fill(b, 0.0);
    for (std::size_t k = 0; k < rows_.size(); ++k)
      b[static_cast<std::size_t>(rows_[k].row)] = rows_[k].sign * (1.0 + restitution[k]) * rates[k];
    dependent_.set_rates(b);
    return {};
  };
  const auto solve = [&]() -> Outcome {
    if (Outcome outcome = system_.linearise(at->t, at->r); !outcome.ok()) return outcome;
    (void)workspace_.constraints.evaluate_rates(model_.parallel, at->r, at->v, b.data());
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      if (closed_[k] != 0) b[static_cast<std::size_t>(rows_[k].row)] *= 1.0 + restitution[k];
    }
    std::ranges::fill(dw, 0.0);
    system_.response().solve_refined(b.data(), x.data(), dw.data());
    minimize_norm(at->r, &x);
    for (std::size_t i = 0; i < size; ++i) v[i] = at->v[i] + (i < 3 * model_.num_moving() ? dw[i] : 0.0);
    measure_rates(at->r, v.data(), &after);
    return {};
  };
  const auto is_wrong = [&](std::size_t k) {
    const double P = rows_[k].sign * x[static_cast<std::size_t>(rows_[k].row)];
    if (closed_[k] != 0) return P * inverse_effective_mass(k) < -resting * speed(k);
    return after[k] + restitution[k] * rates[k] < -resting * speed(k);
  };
  if (Outcome outcome = pivot(*at, may_close, free, solve, is_wrong); !outcome.ok()) return outcome;
  note_impact(at, approaches, rates, after, x);
  std::ranges::copy(v, at->v);
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (approaches[k] != 0) at->leaves[k] = 0;
    if (after[k] > resting * speed(k)) closed_[k] = 0;
  }
  return {};
}

/// Notes an impact, its loss sum of -P (u+ + u-)/2, and the work of what moves by itself.
void UnilateralRows::note_impact(Instant* at, const std::vector<char>& approaches, const std::vector<double>& rates,
                                 const std::vector<double>& after, const std::vector<double>& x) {
  ContactEvent event{.time = at->t};
  for (const bool first : {true, false}) {
    for (std::size_t k = 0; k < rows_.size(); ++k) {
      const double P = closed_[k] != 0 ? rows_[k].sign * x[static_cast<std::size_t>(rows_[k].row)] : 0.0;
      if ((approaches[k] != 0) != first || (!first && !(P * inverse_effective_mass(k) > resting * speed(k)))) continue;
      if (event.equations.empty()) event.change = name_change(k, true);
      event.equations.push_back(user_row(k));
      event.impulses.push_back(std::max(0.0, P));
      event.rates_before.push_back(-rates[k]);
      event.energy_lost -= 0.5 * P * (after[k] + rates[k]);
    }
  }
  at->work.impacts -= event.energy_lost;
  if (model_.is_rheonomic()) {
    double work = 0.0;
    // K'v + xi_t of what is prescribed alone
    std::vector<double> prescribed(at->v, at->v + 3 * model_.num_points()), own(model_.num_rows());
    std::fill_n(prescribed.begin(), 3 * model_.num_moving(), 0.0);
    (void)workspace_.constraints.evaluate_rates(model_.parallel, at->r, prescribed.data(), own.data());
    for (std::size_t a = 0; a < own.size(); ++a) work -= x[a] * own[a];
    at->work.supports += work;
    event.energy_lost -= work;
  }
  at->changes.push_back(std::move(event));
}

/// Closes rows that touch and separate so slowly that their accelerations press them together at once: bounces that
/// would follow ever faster, to an end that is near, and flights below rounding. Takes away their velocity.
Outcome UnilateralRows::end_slow_flights(Instant* at, bool* has_slow) {
  std::vector<double> impulses(model_.num_rows(), 0.0);
  measure_rates(at->r, at->v, &rates_);
  ContactEvent last{.time = at->t, .change = ContactChange::Zeno};
  *has_slow = false;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    const bool bounces = rows_[k].restitution > 0.0 && rows_[k].restitution < 1.0;
    const bool is_slow = rates_[k] > resting * speed(k) && rates_[k] < (bounces ? zeno : unseen) * speed(k);
    if (at->touches[k] == 0 || closed_[k] != 0 || !is_slow || !(accelerations_[k] < -resting * acceleration(k)))
      continue;
    *has_slow = true;
    closed_[k] = 1;
    if (!bounces) continue;
    last.equations.push_back(user_row(k));
    last.rates_before.push_back(-rates_[k]);
  }
  if (!*has_slow) return {};
  if (Outcome outcome = friction_.end_slow_flights(at, rates_); !outcome.ok()) return outcome;
  apply();
  if (Outcome outcome = system_.linearise(at->t, at->r); !outcome.ok()) return outcome;
  const ProjectionReport still = system_.project_velocities(at->t, at->r, at->v, impulses.data());
  if (!still.outcome.ok()) return still.outcome;
  for (std::size_t k = 0; k < rows_.size(); ++k)
    at->work.impacts += 0.5 * rows_[k].sign * impulses[static_cast<std::size_t>(rows_[k].row)] * rates_[k];
  if (!last.equations.empty()) at->changes.push_back(std::move(last));
  return {};
}

// ---- one instant ----

/// Chooses the closed rows among those that touch and rest, by their forces and accelerations.
Outcome UnilateralRows::find_closed(Instant* at) {
  constexpr double certainly = 1e-8;
  std::vector<char> may_close(rows_.size()), are_known;
  measure_rates(at->r, at->v, &rates_);
  for (std::size_t k = 0; k < rows_.size(); ++k)
    may_close[k] = at->touches[k] != 0 && at->leaves[k] == 0 && std::abs(rates_[k]) <= resting * speed(k);
  closed_ = may_close;
  if (Outcome outcome = friction_.choose_closed(at, may_close, &are_known); !outcome.ok() || friction_.are_jammed())
    return outcome;
  const auto solve = [&] {
    Outcome outcome = friction_.empty()
                          ? system_.accelerations({at->t, at->r, at->v}, at->request.evaluated_anew(), {}, at->to)
                          : friction_.choose_modes(at);
    if (!outcome.ok()) return outcome;
    measure_accelerations(at->r, at->v, at->to.a);
    forces_ = system_.lambda();
    minimize_norm(at->r, &forces_);
    return outcome;
  };
  const auto free = [&] {
    Outcome outcome = solve();
    dependent_.set_accelerations(at->r, at->v, at->to.a, forces_);
    return outcome;
  };
  const auto is_off = [&](std::size_t k, double rounding) {
    if (closed_[k] == 0) return accelerations_[k] < (at->falls[k] != 0 ? 0.0 : -rounding * acceleration(k));
    const double p = rows_[k].sign * forces_[static_cast<std::size_t>(rows_[k].row)];
    return p * inverse_effective_mass(k) < -rounding * acceleration(k);
  };
  const auto is_wrong = [&](std::size_t k) { return are_known[k] == 0 && is_off(k, resting); };
  if (Outcome outcome = pivot(*at, may_close, free, solve, is_wrong); !outcome.ok()) return outcome;
  for (std::size_t k = 0; k < rows_.size(); ++k) {
    if (are_known[k] == 0 || may_close[k] == 0 || !is_off(k, certainly)) continue;
    return {Status::NotConverged, "what was found at t = " + text(at->t) +
                                      " misses the law: " + equation_name(model_.system, user_row(k)) +
                                      (closed_[k] != 0 ? " pulls" : " closes")};
  }
  return {};
}

}  // namespace tanor::detail
