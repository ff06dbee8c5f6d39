#include <algorithm>
#include <array>
#include <cmath>

#include "base/with_unit.hpp"
#include "simulation/implementation.hpp"
#include "simulation/taken_out.hpp"
#include "system/formula_names.hpp"
#include "system/strengths.hpp"

namespace tanor {
using namespace detail;

namespace {

using Which = Observables::Which;

/// Marks what a solve has not found.
void forget_forces(Solution* at) {
  for (const auto array :
       {&Solution::accelerations, &Solution::multipliers, &Solution::reactions, &Solution::support_forces})
    std::ranges::fill(at->*array, std::numeric_limits<double>::quiet_NaN());
}

bool takes(const Event& event) {
  return event.action == EventAction::Break || event.action == EventAction::Release;
}

/// Returns what an event takes out, from `of` or from the member of which its condition speaks. Throws InputError if
/// that is nothing, or nothing that breaks or can be let go.
std::optional<Thing> find_what_goes(const Things& things, const Event& event, const Condition& condition) {
  const bool breaks = event.action == EventAction::Break;
  std::optional<Thing> thing;
  if (!event.of.empty()) {
    try {
      thing = things.find({event.of, 0}, {Thing::List::Constraints, Thing::List::Supports, Thing::List::Forces});
    } catch (const TextFault& fault) {
      throw InputError("/of", fault.problem);
    }
  } else {
    thing = condition.thing();
  }
  if (!thing) {
    throw InputError("/of", std::string("what the event ") + (breaks ? "breaks" : "releases") +
                                " is not said: the condition \"" + event.when + "\" speaks of no single thing");
  }
  if (thing->list != Thing::List::Supports && !thing->member && things.num_members(*thing) == 1) thing->member = 0;
  const std::string name = "'" + things.name(*thing) + "'";
  const System& system = things.system();
  const std::string_view kind = thing->list == Thing::List::Supports ? "support"
                                : thing->list == Thing::List::Forces ? kind_name(system.forces[thing->index])
                                                                     : kind_name(system.constraints[thing->index]);
  const std::array joints{KindOf<Rods>::name, KindOf<Ropes>::name, KindOf<Pulleys>::name, KindOf<Springs>::name,
                          KindOf<Bonds>::name};
  if (breaks && std::ranges::count(joints, kind) == 0)
    throw InputError("/do", name + " is a " + std::string(kind) +
                                " and does not break; rods, ropes, pulleys, springs and bonds do" +
                                (thing->list == Thing::List::Forces ? "" : ", and release lets go of it"));
  const bool is_force = thing->list == Thing::List::Forces;
  if (!breaks && (is_force || std::ranges::count(joints, kind) > 0))
    throw InputError(
        "/do", name + " is a " + (is_force ? "force" : std::string(kind)) + "; release is for supports and guides");
  if (thing->list != Thing::List::Supports && !thing->member)
    throw InputError("/of", name + " has " + text(things.num_members(*thing)) + " members; name one");
  return thing;
}

/// Reads a condition and checks what it is to take out.
std::unique_ptr<Condition> read_condition(const Things& things, const Event& event) {
  if (event.name != event.when) check_name(event.name, "/name");
  auto condition = std::make_unique<Condition>(things, event.when, event.parameters);
  check_enum(event.action, EventAction::Release, "/event/action");
  if (takes(event)) check_let_go(things.system(), *find_what_goes(things, event, *condition));
  return condition;
}

}  // namespace

void check_event(const System& system, const Event& event) {
  (void)read_condition(Things(system), event);
}

// ---- observables ----

std::size_t Simulation::Implementation::add_observable(const Observable& what) {
  if (observables == nullptr) observables = std::make_unique<Observables>(observed_system(), taken);
  refuse_name_of_time(what);
  const std::size_t number = observables->add(what);
  if (what.every_step && !is_advancing && outcome.ok())
    observables->take(look_at(observables->needs(Which::OfEveryStep)), Which::OfEveryStep);
  return number;
}

void Simulation::Implementation::explain_gone(Observables* which) const {
  which->explain_gone([this](const std::string& place) -> std::string {
    // A look in an advance leaves new passages to those who act on them.
    const auto last = std::find_if(passages.rbegin(), passages.rend(), [&](const Passage& each) {
      return !each.taken.empty() && (place == each.taken || place.starts_with(each.taken + "/"));
    });
    if (last == passages.rend()) return "";
    constexpr int digits = 6;
    return (last->action == EventAction::Release ? "released at t = " : "broken at t = ") +
           with_unit(text(last->time, digits), system().units.time);
  });
}

std::span<const Observed> Simulation::Implementation::observe(bool counts) {
  if (observables == nullptr) return {};
  if (!outcome.ok()) return observables->found();
  observables->take(look_at(observables->needs(Which::All)), Which::All, counts);
  explain_gone(observables.get());
  return observables->found();
}

std::vector<Observed> Simulation::Implementation::observe(std::span<const Observable> wanted) {
  Observables others(observed_system(), taken);
  for (const Observable& each : wanted) others.add(each);
  if (outcome.ok()) {
    others.take(look_at(others.needs(Which::All)), Which::All);
    explain_gone(&others);
  }
  return {others.found().begin(), others.found().end()};
}

void Simulation::Implementation::observe_step() {
  if (observables != nullptr && observables->has_of_every_step())
    observables->take(look_at(observables->needs(Which::OfEveryStep)), Which::OfEveryStep);
}

/// Returns an answer, with the friction that was seen, as observables read it.
ObservedInstant Simulation::Implementation::describe(const Solution& at, double t, const Energy& energy) const {
  return {.time = t,
          .positions = at.positions,
          .velocities = at.velocities,
          .accelerations = at.accelerations,
          .multipliers = at.multipliers,
          .reactions = at.reactions,
          .support_forces = at.support_forces,
          .friction = seen.friction,
          .kinetic = energy.kinetic,
          .potential = energy.potential,
          .degrees_of_freedom = static_cast<std::size_t>(forms.degrees_of_freedom()),
          .self_stress = seen.self_stress,
          .has_prestress = !forms.plan.prestress_rigid_equations.empty()};
}

/// Returns what observables read at the present state.
ObservedInstant Simulation::Implementation::look_at(Needs needs) {
  if (is_advancing) look_on_the_way(needs);
  const Solution& at = is_advancing ? seen.at : now;
  if (needs.friction) seen.friction = friction_forces();
  if (needs.solves()) seen.self_stress = find_self_stress(forms);
  return describe(without_unknown(at), state.t, {report.energy.kinetic, report.energy.potential});
}

const Solution& Simulation::Implementation::without_unknown(const Solution& at) {
  const std::vector<std::size_t>& unknown = forms.plan.prestress_rigid_equations;
  if (unknown.empty()) return at;
  seen.known = at;
  forget_equations(system(), unknown, &seen.known);
  return seen.known;
}

/// Fills `seen.at`. Nothing is solved where the last step left the accelerations at its end.
void Simulation::Implementation::look_on_the_way(Needs needs) {
  if (seen.at.positions.empty()) seen.at = make_solution(model.system, now.coordinates.size());
  const Parts parts = needs.forces || needs.places || !needs.multipliers ? Parts::All : Parts::Multipliers;
  if ((needs.forces || needs.multipliers) && !integration.knows_acceleration()) {
    solve_on_the_way(parts, &seen.at);
    if (!seen.at.outcome.ok()) forget_forces(&seen.at);
    return;
  }
  if (needs_points(parts)) write_points();
  if (needs.forces || needs.multipliers) {
    seen.at.outcome = write_solution(state.at(), state.reactions, parts, &seen.at);
  } else {
    model.numbering.scatter_points(points.r, seen.at.positions);
    model.numbering.scatter_points(points.v, seen.at.velocities);
  }
}

/// Returns what conditions read at a state inside a step.
ObservedInstant Simulation::Implementation::look_inside(double t, const double* x, const double* x_dot, Needs needs) {
  const Kinematics here{t, x, x_dot};
  if (seen.at.positions.empty()) seen.at = make_solution(model.system, now.coordinates.size());
  Solution& at = seen.at;
  Energy energy;
  if (needs.solves()) {
    const Look look(this);
    std::vector<double> at_a(form.size());
    Reactions found = form.no_reactions();
    at.outcome =
        form.accelerations(here, integration.request(Gradients::Evaluate), {at_a.data(), nullptr, nullptr, &found});
    form.write_points(here, at_a.data(), found, points.r.data(), points.v.data(), points.w.data());
    if (needs.friction) seen.friction = friction_of(found);
    if (at.outcome.ok()) at.outcome = write_solution(here, found, Parts::All, &at);
    if (!at.outcome.ok()) forget_forces(&at);
  } else {
    form.write_points(here, state.a.data(), state.reactions, points.r.data(), points.v.data(), points.w.data());
    model.numbering.scatter_points(points.r, at.positions);
    model.numbering.scatter_points(points.v, at.velocities);
  }
  if (needs.energy) energy = form.energy(t, x, x_dot);
  return describe(needs.solves() ? without_unknown(at) : at, t, energy);
}

/// Compares the numbers that were told with those of texts that are read anew, from the reactions that the certificate
/// has found anew and from energies of the system alone.
void Simulation::Implementation::verify_observables(const Reactions& anew, Certificate* certificate) {
  if (observables == nullptr || certificate->checks.empty()) return;  // nothing moves
  const Needs needs = observables->needs(Which::All);
  if (observables->time() != state.t) observables->take(look_at(needs), Which::All, false);
  if (seen.at.positions.empty()) seen.at = make_solution(model.system, now.coordinates.size());
  if (!write_solution(anew, &seen.at).ok()) return;
  seen.at.time = state.t;
  seen.friction = friction_of(anew);
  if (needs.solves()) seen.self_stress = find_self_stress(forms);
  Observables second(observed_system(), taken), nudged(observed_system(), taken);
  second.add(*observables);
  nudged.add(*observables);
  Solution known = without_unknown(seen.at);
  ObservedInstant at = describe(known, state.t, {});
  if (needs.energy) find_energies(model.system, seen.at, &at);
  second.take(at, Which::All);
  // Numbers that cancel are measured by their change where what they are found from changes a little.
  constexpr double little = 1e-9;
  const auto nudge = [](std::span<double> numbers) {
    double size = 0.0;
    for (const double each : numbers) size = std::max(size, std::isnan(each) ? 0.0 : std::abs(each));
    for (std::size_t i = 0; i < numbers.size(); ++i)
      numbers[i] += little * size * std::cos(2.3 * static_cast<double>(i));
  };
  for (std::vector<double>* const array :
       {&known.accelerations, &known.multipliers, &known.reactions, &known.support_forces, &seen.friction})
    nudge(*array);
  double fall = 0.0;  // the energy of the largest forces along the scene
  for (const double each : work.f) fall += std::abs(each) * model.scene_size;
  at.kinetic += little * at.kinetic;
  at.potential -= little * (std::abs(at.potential) + fall);
  nudged.take(at, Which::All);
  constexpr const char* what = "second evaluation of the observables";
  CertificateCheck check{.identity = what, .words = what};
  for (std::size_t k = 0; k < second.found().size(); ++k) {
    const Observed &first = observables->found()[k], &other = second.found()[k];
    double size = 0.0, difference = 0.0;
    for (std::size_t i = 0; i < first.values.size(); ++i) {
      const double value = other.values[i];
      const bool are_none = std::isnan(first.values[i]) && std::isnan(value);  // of what was taken out
      if (are_none || first.values[i] == value) continue;
      size = std::max({size, std::abs(value), std::abs(nudged.found()[k].values[i] - value) / little});
      difference = larger(difference, std::abs(first.values[i] - value));
    }
    double error = difference == 0.0 ? 0.0 : difference / size;
    if (std::isnan(error)) error = std::numeric_limits<double>::infinity();
    if (error >= check.error) check = {what, error, 0.0, first.name, what};
  }
  // Forces from two solves differ by the rounding of S.
  constexpr double digits = 1e3 * std::numeric_limits<double>::epsilon();
  const double rcond = certificate->reciprocal_condition;
  check.allowed = std::clamp(std::isfinite(rcond) ? digits / rcond : digits, 1e-11, Certificate::fewest_digits);
  certificate->checks.push_back(check);
}

// ---- events ----

std::size_t Simulation::Implementation::add_event(Event event) {
  if (event.name.empty()) event.name = event.when;
  // Without a name an event has that of its condition, which several may share; so may functions of the caller.
  for (const Event& other : events)
    if (!event.when.empty() && event.name == other.name && (event.name != event.when || other.name != other.when))
      throw InputError("/name", "two events have the name \"" + event.name + "\"");
  check_enum(event.direction, Event::Direction::Falling, "/event/direction");
  const std::size_t number = events.size();
  Watch::Function function{{}, event.direction, event.stops, event.name, false};
  if (event.when.empty()) {
    if (!event.value) throw InputError("/event", "\"" + event.name + "\" has no function");
    conditions.push_back(nullptr);
    events.push_back(event);
    events.back().action = event.stops ? EventAction::Stop : EventAction::Report;
    function.value = [this, value = event.value, at_r = std::vector<double>(points.r.size()),
                      at_v = std::vector<double>(points.v.size()),
                      size = 3 * system().num_points()](double t, const double* x, const double* x_dot) mutable {
      form.write_points({t, x, x_dot}, state.a.data(), state.reactions, points.r.data(), points.v.data(),
                        points.w.data());
      model.numbering.scatter_points(points.r, at_r);
      model.numbering.scatter_points(points.v, at_v);
      return form.sum(value(t, std::span(at_r).first(size), std::span(at_v).first(size)));
    };
  } else {
    if (event.value) throw InputError("/event", "\"" + event.name + "\" has both a function and a condition");
    if (event.direction != Event::Direction::Both)
      throw InputError("/event/direction", "a condition passes when it comes true; a function alone has a direction");
    if (!part.is_whole()) throw InputError("/event", "conditions need the whole system on one rank");
    if (forms.is_tangent() && takes(event))
      throw InputError("/event", "what coordinates place cannot be taken out; take solver.form normal");
    conditions.push_back(read_condition(things(), event));
    events.push_back(event);
    const Condition* const condition = conditions.back().get();
    const Needs needs = condition->needs();
    constexpr double never = -1.0;
    function.value = [this, condition, needs, number, is_done = has_taken_its_thing(number)](double t, const double* x,
                                                                                             const double* x_dot) {
      if (is_done || truths[number].is_given_up) return never;
      ++truths[number].looks;
      return condition->value(look_inside(t, x, x_dot, needs));
    };
    function.direction = Event::Direction::Rising;
    function.stops = function.passes_at_start = true;
    function.solves = needs.solves();
  }
  integration.watch().add(std::move(function));
  truths.emplace_back();
  return number;
}

/// Refuses a condition that nobody can ever know.
void Simulation::Implementation::refuse_unknown(const Event& event) {
  if (event.when.empty() || !part.is_whole() || !outcome.ok()) return;
  const std::unique_ptr<Condition> condition = read_condition(things(), event);
  const Needs needs = condition->needs();
  if (!needs.solves()) return;
  if (const std::string why = condition->explain(look_at(needs)); !why.empty())
    throw InputError("/event", "\"" + event.when + "\" is not known: " + why);
}

void Simulation::Implementation::add_breaks() {
  for (std::size_t g = 0; g < system().constraints.size(); ++g) {
    const Constraint& group = system().constraints[g];
    if (strengths_of(group).empty() || shape_of(group).members == 0) continue;
    const std::string name = constraint_name(system(), g);
    try {
      add_event({.name = "breaks_at of " + name,
                 .when = "any utilisation(" + quoted_name(name) + ") > 1",
                 .action = EventAction::Break});
    } catch (const InputError& error) {
      throw InputError("/constraints/" + text(g) + "/breaks_at", error.what());
    }
  }
}

/// Returns true if what the event names is taken out.
bool Simulation::Implementation::has_taken_its_thing(std::size_t event) const {
  if (events[event].of.empty() || !takes(events[event])) return false;
  return things().is_absent(*find_what_goes(things(), events[event], *conditions[event]));
}

std::span<const Passage> Simulation::Implementation::list_passages() {
  const std::vector<Passage>& found = integration.watch().passages();
  for (; seen_passages < found.size(); ++seen_passages) {
    passages.push_back(found[seen_passages]);
    passages.back().name = events[passages.back().event].name;
    passages.back().action = events[passages.back().event].action;
  }
  return passages;
}

/// Gives up reports whose conditions change too often, as of noise about a limit.
void Simulation::Implementation::give_up_noise() {
  constexpr double looks_of_step = 50.0, looks_at_least = 2e4;
  for (std::size_t number = 0; number < events.size(); ++number) {
    Truth& truth = truths[number];
    const bool is_dear = truth.looks > looks_at_least + looks_of_step * static_cast<double>(report.steps);
    if (!is_dear || truth.is_given_up || events[number].action != EventAction::Report) continue;
    truth.is_given_up = true;
    std::string& warning = report.accuracy_warning;
    warning += (warning.empty() ? "event \"" : "; event \"") + events[number].name + "\" changes too often, " +
               text(static_cast<std::size_t>(std::ranges::count(passages, number, &Passage::event))) +
               " times up to t = " + with_unit(text(state.t), system().units.time) + ", and is not followed further";
  }
}

Simulation::Implementation::Acts Simulation::Implementation::act() {
  Acts acts;
  const std::size_t before = passages.size();
  list_passages();
  std::vector<char> has_passed(events.size(), 0);
  for (std::size_t k = before; k < passages.size(); ++k)
    if (passages[k].time == state.t) has_passed[passages[k].event] = 1;
  for (std::size_t number = 0; number < events.size(); ++number) {
    const Event& event = events[number];
    if (conditions[number] == nullptr) {
      acts.stops = acts.stops || (has_passed[number] != 0 && event.stops);
      continue;
    }
    const Condition& condition = *conditions[number];
    Truth& truth = truths[number];
    if (has_taken_its_thing(number) || truths[number].is_given_up) continue;
    const double value = condition.value(look_at(condition.needs()));
    if (has_passed[number] == 0) {
      // At the instant of a passage the value is rounding.
      if (truth.last_passage == state.t) continue;
      const bool was_true = std::exchange(truth.is_true, value > 0.0);
      if (was_true || !truth.is_true) continue;
      passages.push_back({.event = number, .time = state.t, .rises = true, .name = event.name, .action = event.action});
    }
    truth.is_true = true;
    truth.last_passage = state.t;
    Passage& passage =
        *std::find_if(passages.rbegin(), passages.rend(), [&](const Passage& each) { return each.event == number; });
    const std::optional<Thing> thing = condition.thing();
    passage.member = thing ? things().name(*thing) : condition.member();
    acts.stops = acts.stops || event.action == EventAction::Stop;
    if (!takes(event)) continue;
    const Thing goes = *find_what_goes(things(), event, condition);
    passage.member = things().name(goes);
    if (std::ranges::count(acts.taken, goes, &std::pair<Thing, std::size_t>::first) > 0)
      passage.action = EventAction::Report;  // another event takes it out
    acts.taken.emplace_back(goes, static_cast<std::size_t>(&passage - passages.data()));
    truth.is_true = false;  // the next member may follow at once
    truth.last_passage = std::numeric_limits<double>::quiet_NaN();
  }
  give_up_noise();
  return acts;
}

std::vector<char> Simulation::Implementation::find_free_points() const {
  std::vector<char> is_free(model.num_points(), 1);
  for_each_member(model.system, [&](std::span<const Index> joined, int) {
    for (const Index point : joined) is_free[static_cast<std::size_t>(point)] = 0;
  });
  for (const Support& support : model.system.supports)
    for (const Index point : support.points) is_free[static_cast<std::size_t>(point)] = 0;
  return is_free;
}

/// Tells the search for passages which ones were at the present state.
void Simulation::Implementation::keep_signs() {
  for (const Passage& passage : passages)
    if (passage.time == state.t && (conditions[passage.event] == nullptr || truths[passage.event].is_true))
      integration.watch().note_passed(passage.event, passage.rises);
}

void Simulation::Implementation::continue_from(const Implementation& before) {
  passages = before.passages;
  for (const Event& event : before.events) add_event(event);
  truths = before.truths;
  keep_signs();
  if (before.observables == nullptr) return;
  observables = std::make_unique<Observables>(observed_system(), taken);
  observables->add(*before.observables);
}

}  // namespace tanor
