#include <algorithm>
#include <limits>

#include "simulation/implementation.hpp"
#include "simulation/taken_out.hpp"
#include "system/members.hpp"

namespace tanor {

std::unique_ptr<Simulation::Implementation> Simulation::Implementation::make_without(const Implementation& of,
                                                                                     std::vector<Thing> things) {
  const System whole = of.system();
  const auto make = [&](System system) {
    return std::make_unique<Implementation>(std::move(system), of.options, of.solver_options, of.part, of.t_begin);
  };
  std::unique_ptr<Implementation> made = make(without(whole, things, of.t_begin));
  // Points that a prestress held before, and holds without them, stay held.
  const std::vector<Index>& held = of.forms.plan.prestress_rigid_points;
  std::vector<Index> rigid = made->find_prestress_rigid_points();
  std::erase_if(rigid, [&](Index point) { return std::ranges::find(held, point) == held.end(); });
  if (!rigid.empty()) {
    System system = made->model.system;
    std::vector<std::size_t> equations = list_prestress_rigid_equations(system, rigid);
    hold_rigid_points(&system, rigid);
    made = make(std::move(system));
    made->forms.plan.prestress_rigid_points = std::move(rigid);
    made->forms.plan.prestress_rigid_equations = std::move(equations);
  }
  const std::size_t num_outside = made->model.num_points() - whole.num_points();
  made->forms.plan.points -= num_outside;
  made->forms.plan.supports -= num_outside;
  made->given = whole;
  made->taken = std::move(things);
  return made;
}

std::vector<std::size_t> Simulation::Implementation::rows_taken_out() const {
  std::vector<std::size_t> rows;
  for (const Thing& thing : taken) {
    if (thing.list != Thing::List::Constraints) continue;
    const std::size_t count = shape_of(system().constraints[thing.index]).rows_per_member;
    const std::size_t first = now.first_row[thing.index] + *thing.member * count;
    for (std::size_t row = first; row < first + count; ++row) rows.push_back(row);
  }
  return rows;
}

void Simulation::Implementation::forget_what_is_gone(Solution* at) const {
  for (const std::vector<std::size_t>& rows : {rows_taken_out(), forms.plan.prestress_rigid_equations})
    for (const std::size_t row : rows) at->multipliers[row] = std::numeric_limits<double>::quiet_NaN();
}

std::vector<std::size_t> Simulation::Implementation::numbers_of(std::span<const Thing> things) {
  std::vector<std::size_t> numbers;
  for (const Thing& thing : things)
    for (const std::size_t number : {static_cast<std::size_t>(thing.list), thing.index,
                                     thing.member.value_or(std::numeric_limits<std::size_t>::max())})
      numbers.push_back(number);
  return numbers;
}

namespace {

/// Calls visit(extreme) for all extremes of observables, in one order.
template <class Visit>
void for_each_extreme(std::span<Observed> observed, const Visit& visit) {
  for (Observed& each : observed)
    for (std::vector<Extreme>* const list : {&each.least, &each.largest})
      for (Extreme& extreme : *list) visit(extreme);
}

}  // namespace

/// Writes the extremes of observables, the truth of conditions and the passages, which a motion that is resumed goes on
/// from.
void Simulation::Implementation::write_requests(Snapshot* snapshot) {
  snapshot->taken = numbers_of(taken);
  list_passages();
  snapshot->passages = passages;
  snapshot->truths = truths;
  if (observables == nullptr) return;
  for_each_extreme(observables->found(), [&](const Extreme& extreme) { snapshot->extremes.push_back(extreme); });
}

/// Reads them if they are of the same observables and events; passages that are known here already stay.
void Simulation::Implementation::read_requests(const Snapshot& snapshot) {
  std::erase_if(passages, [&](const Passage& passage) { return passage.time > snapshot.time; });
  seen_passages = integration.watch().passages().size();
  if (snapshot.truths.size() == truths.size()) truths = snapshot.truths;
  std::size_t num_extremes = 0;
  if (observables != nullptr) for_each_extreme(observables->found(), [&](const Extreme&) { ++num_extremes; });
  if (num_extremes != snapshot.extremes.size()) return;
  auto next = snapshot.extremes.begin();
  if (observables != nullptr) for_each_extreme(observables->found(), [&](Extreme& extreme) { extreme = *next++; });
  if (!passages.empty()) return;
  passages = snapshot.passages;
  std::erase_if(passages, [&](const Passage& passage) { return passage.event >= events.size(); });
  for (Passage& passage : passages) {
    passage.name = events[passage.event].name;
    passage.action = events[passage.event].action;
  }
}

void Simulation::Implementation::restore(std::unique_ptr<Implementation>* at, std::span<const std::byte> saved) {
  (*at)->refuse_inside_advance("restore");
  const Snapshot snapshot = unpack(saved, fingerprint_of((*at)->system()));
  if (snapshot.taken != numbers_of((*at)->taken)) {
    std::vector<Thing> things;
    for (std::size_t k = 0; k + 2 < snapshot.taken.size(); k += 3) {
      const std::size_t member = snapshot.taken[k + 2];
      things.push_back({static_cast<Thing::List>(snapshot.taken[k]), snapshot.taken[k + 1],
                        member == std::numeric_limits<std::size_t>::max() ? std::nullopt : std::optional(member)});
    }
    std::unique_ptr<Implementation> other = make_without(**at, std::move(things));
    other->continue_from(**at);
    *at = std::move(other);
  }
  (*at)->restore(snapshot);
  (*at)->keep_signs();
}

namespace {

/// Returns "point 3 and 2 more are" of marked points; empty if there are none.
std::string name_points(const std::vector<char>& is_marked) {
  const auto count = static_cast<std::size_t>(std::ranges::count(is_marked, 1));
  if (count == 0) return {};
  const std::string point =
      "point " + text(static_cast<std::size_t>(std::ranges::find(is_marked, 1) - is_marked.begin()));
  return point + (count > 1 ? " and " + text(count - 1) + " more are" : " is");
}

/// Returns the user's rows to which the numbers of a discrete state belong: one-sided rows and then, counted behind all
/// rows, the guides of contacts with friction.
std::vector<std::size_t> rows_of_modes(SimulatedMotion& of) {
  const Numbering& numbering = of.model.numbering;
  const auto user_row = [&](Index row) {
    return static_cast<std::size_t>(numbering.user_row[static_cast<std::size_t>(row)]);
  };
  std::vector<std::size_t> rows;
  for (const OneSidedRow& each : numbering.one_sided) rows.push_back(user_row(each.row));
  const Tangents& tangents = of.work.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c)
    rows.push_back(numbering.num_user_rows + user_row(tangents[c].guide_row[0]));
  return rows;
}

/// Returns the modes that one-sided rows and contacts which are left had before: closed or not, sticking or not.
std::vector<int> modes_of_rest(SimulatedMotion& before, SimulatedMotion& after) {
  std::vector<int> modes(2 * before.model.numbering.num_user_rows), result;
  const std::vector<int> state = before.form.events()->discrete_state();
  const std::vector<std::size_t> rows = rows_of_modes(before);
  for (std::size_t k = 0; k < state.size(); ++k) modes[rows[k]] = state[k];
  for (const std::size_t row : rows_of_modes(after)) result.push_back(modes[row]);
  return result;
}

}  // namespace

Outcome Simulation::Implementation::check_rest() const {
  if (!outcome.ok() || forms.normal == nullptr || work.rank == model.numbering.first_idle_row()) return outcome;
  System here = model.system;
  here.velocities = now.velocities;  // points that move are not held
  std::vector<char> is_rigid(here.num_points(), 0);
  for (const Index point :
       detail::find_prestress_rigid_points(here, forms.normal->linearization().dependences().list_rows()))
    is_rigid[static_cast<std::size_t>(point)] = 1;
  const std::string names = name_points(is_rigid);
  if (names.empty()) return {};
  return {Status::Singular, "the rest is singular: " + names +
                                " held rigid by prestress between supports, and the forces there are not determined"};
}

Outcome Simulation::Implementation::take_out(std::unique_ptr<Implementation>* at, const Thing& thing,
                                             std::size_t number) {
  Implementation& before = **at;
  if (before.things().is_absent(thing)) return before.outcome;  // two events name it
  const Energy energy_before = before.form.energy(before.state.t, before.state.x.data(), before.state.v.data());
  const std::vector<std::byte> progress = before.save_progress();
  std::vector<double> r = before.now.positions, v = before.now.velocities;
  const std::size_t size = 3 * before.system().num_points();
  std::vector<Thing> things = before.taken;
  things.push_back(thing);
  std::unique_ptr<Implementation> after = make_without(before, std::move(things));
  const System& system = after->model.system;
  r.resize(size);
  v.resize(size);
  r.insert(r.end(), system.positions.begin() + static_cast<std::ptrdiff_t>(size), system.positions.end());
  v.resize(r.size());
  if (after->has_sides()) after->form.events()->restore_discrete_state(modes_of_rest(before, *after));
  after->restore_progress(progress, r, v);
  after->continue_from(before);
  if (after->has_sides()) {
    const std::span<const ContactEvent> changes = after->form.events()->changes_of_switch();
    std::vector<ContactEvent>& events = after->report.contact_events;
    events.insert(events.end(), changes.begin(), changes.end());
  }

  // The change of energy counts as work, that of supports where one begins to move with its weight and velocity, so
  // that the drift remains that of the method.
  const Energy energy = after->form.energy(after->state.t, after->state.x.data(), after->state.v.data());
  constexpr double rounding = 1e-12;
  EnergyReport& report = after->report.energy;
  double lost = energy_before.kinetic + energy_before.potential - energy.kinetic - energy.potential;
  if (std::abs(lost) <= rounding * report.scale) lost = 0.0;
  report.kinetic = energy.kinetic;
  report.potential = energy.potential;
  report.now = energy.kinetic + energy.potential;
  const bool is_support = thing.list == Thing::List::Supports;
  (is_support ? report.work_of_supports : report.work_of_forces) -= lost;
  (is_support ? after->state.work.supports : after->state.work.forces) -= lost;
  std::vector<char> is_free = after->find_free_points();
  const std::vector<char> was_free = before.find_free_points();
  for (std::size_t i = 0; i < was_free.size(); ++i) is_free[i] = is_free[i] != 0 && was_free[i] == 0 ? 1 : 0;
  Passage& passage = after->passages[number];
  passage.taken = place_in_system(thing);
  // The energy with which a support begins to move comes from outside.
  if (thing.list == Thing::List::Forces) passage.energy_lost = lost;
  if (passage.rest = name_points(is_free); !passage.rest.empty()) passage.rest += " without constraints";
  after->outcome = after->check_rest();
  *at = std::move(after);
  return (*at)->outcome;
}

Outcome Simulation::Implementation::advance_through_events(std::unique_ptr<Implementation>* at, double t_end,
                                                           const Observer& observer) {
  const auto act_fully = [at](bool* stops) -> Outcome {
    *stops = false;
    while (true) {
      Acts acts = (*at)->act();
      *stops = *stops || acts.stops;
      if (acts.taken.empty()) return {};
      (*at)->observe(true);  // what goes has its extremes here
      std::string names;
      Outcome found;  // of the last one, when all are gone
      for (const auto& [thing, passage] : acts.taken) {
        names += (names.empty() ? "" : ", ") + (*at)->things().name(thing);
        found = take_out(at, thing, passage);
      }
      if (found.ok()) continue;
      found.what = "after " + names + " was taken out: " + found.what;
      return (*at)->outcome = found;
    }
  };
  // An advance to the present time acts on what is true there, and makes no step.
  const bool is_there = t_end == (*at)->state.t;
  if (!is_there && std::ranges::none_of((*at)->conditions, [](const auto& condition) { return condition != nullptr; }))
    return (*at)->advance(t_end, observer);
  bool stops = false;
  (*at)->refuse_inside_advance("advance_to");
  if (!(*at)->outcome.ok()) return (*at)->outcome;
  if (Outcome found = act_fully(&stops); !found.ok() || stops) return found;
  if (is_there) return (*at)->outcome;
  while (true) {
    (*at)->list_passages();
    bool goes_on = true;
    const Observer watched = [&](const MotionReport& report) { return goes_on = !observer || observer(report); };
    if (const Outcome advanced = (*at)->advance(t_end, watched); !advanced.ok()) return advanced;
    if (Outcome found = act_fully(&stops); !found.ok()) return found;
    // A passage that is taken back, as of two equal numbers, ends the advance too.
    if (stops || !goes_on || (*at)->state.t >= t_end) return (*at)->outcome;
  }
}

}  // namespace tanor
