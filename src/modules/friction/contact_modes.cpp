#include "friction/contact_modes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text.hpp"
#include "base/with_unit.hpp"

namespace tanor::detail {

namespace {

constexpr std::size_t unlimited = std::numeric_limits<std::size_t>::max();

}  // namespace

// ---- events ----

/// The value of a contact that sticks is its distance to the limit; the value of one that slides is its velocity along
/// its slip direction.
void ContactModes::evaluate_events(const Kinematics& at, const Reactions& found, double* values) {
  const double* const lambda = found.lambda.data();
  // Slower backward sliding, relative to the speed around the contact, is the rounding of a start from rest.
  constexpr double speed_slack = 1e-13;
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (!state_.may_stick(c)) continue;
    if (state_.tangents.is_open(c)) {
      *values++ = 1.0;
    } else if (state_.tangents.sticks(c)) {
      const double limit = state_.limit(c, lambda), held = state_.held(c, lambda);
      *values++ = limit + held > 0.0 ? (limit - held) / (limit + held) + 2.0 * limit_slack : 1.0;
    } else {
      const double forward = dot(state_.tangents.sliding_velocity(c, at.v), state_.laws.slip_direction(c));
      *values++ = forward / work_.scales.speed(state_.neighbourhood(c)) + speed_slack;
    }
  }
}

/// The shape for a contact that sticks is limit^2 - held^2, where mu^2 |N|^2 and |F|^2 are quadratic in the
/// multipliers.
void ContactModes::shape_events(const Reactions& found, const double* values, double* shapes) const {
  const double* const lambda = found.lambda.data();
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (!state_.may_stick(c)) continue;
    const double value = *values++;
    if (state_.tangents.sticks(c)) {
      const double limit = state_.limit(c, lambda), held = state_.held(c, lambda);
      const double slack = 2.0 * limit_slack * (limit + held);
      *shapes++ = (limit - held + slack) * (limit + held);
    } else {
      *shapes++ = value;
    }
  }
}

// ---- the driver ----

Outcome ContactModes::begin(double t, const double* r, double* v, const Request& request,
                            const AccelerationOutput& to) {
  Tangents& tangents = state_.tangents;
  ModeSwitch at{t, r, v, to, request};
  at.at_rest.assign(state_.size(), 0);
  at.has_changed.assign(friction_.islands().size(), 1);
  for (std::size_t c = 0; c < state_.size(); ++c) tangents.set_stick(c, false);
  state_.places.forget();
  state_.forget_restored();
  if (Outcome outcome = state_.system.linearise(t, r); !outcome.ok()) return outcome;
  state_.set_sliding_speeds();
  for (std::size_t c = 0; c < state_.size(); ++c) {
    at.at_rest[c] = state_.may_rest(c) && state_.is_at_rest(c, v);
    tangents.set_stick(c, at.at_rest[c] != 0);
    state_.laws.set_slip_direction(c, {});
  }
  state_.laws.keep_slip_directions(v);
  state_.verdict.uniqueness = Uniqueness::NotAsked;
  std::ranges::fill(state_.softness, 0);
  std::ranges::fill(state_.overloads, 0);
  std::fill(state_.system.lambda().begin(), state_.system.lambda().end(), 0.0);
  return choose(std::move(at));
}

/// A contact that was struck may move now though it was at rest, and nothing tells yet where it slides to.
Outcome ContactModes::switch_guides(double t, const double* r, double* v, std::span<const std::size_t> which,
                                    std::span<const GuideChange> guides, const Request& request,
                                    const AccelerationOutput& to) {
  constexpr double rounding_of_impacts = 100.0;
  Tangents& tangents = state_.tangents;
  const ContactIslands& islands = friction_.islands();
  ModeSwitch at{t, r, v, to, request};
  at.at_rest.assign(state_.size(), 0);
  at.has_changed.assign(islands.size(), 0);
  std::vector<char> is_met(num_events(), 0);
  for (const std::size_t event : which) is_met[event] = 1;
  std::size_t event = 0;
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (!state_.may_stick(c)) continue;
    const GuideChange guide = guides.empty() ? GuideChange::None : guides[c];
    const bool is_struck = guide == GuideChange::Struck, is_now = is_met[event++] != 0;
    if (is_now || guide != GuideChange::None) at.has_changed[islands.of_contact[c]] = 1;
    if (is_struck || tangents.is_open(c)) state_.forget(c);
    if (tangents.is_open(c)) continue;
    const bool has_stopped = is_struck ? state_.is_at_rest(c, v) : is_now || state_.is_at_rest(c, v);
    const double moves = rounding_of_impacts * state_.sliding_threshold(c);
    if (tangents.sticks(c) && (!is_struck || state_.sliding_speed(c, v) <= moves)) {
      at.at_rest[c] = 1;
      if (is_now) at.releases.push_back(c);
    } else if (has_stopped) {
      at.at_rest[c] = 1;
      tangents.set_stick(c, true);
      at.has_changed[islands.of_contact[c]] = 1;
    } else {
      tangents.set_stick(c, false);
    }
  }
  return choose(std::move(at));
}

/// Chooses the modes of all contacts at rest together. Islands of few contacts are counted as a whole, and the search
/// begins with their choice. In larger islands it begins with all contacts sticking but `releases`.
Outcome ContactModes::choose(ModeSwitch at) {
  work_of_rest_ = {};
  const bool shared_loads = state_.shares_loads;
  state_.forget_shares();
  at.before.assign(at.v, at.v + 3 * model_.num_points());
  at.passes.assign(state_.size(), 0);
  for (bool has_more = at.num_at_rest() > 0; has_more; has_more = bring_along(&at)) {
    if (Outcome outcome = put_to_rest(&at); !outcome.ok()) return outcome;
  }
  forget_slow_directions(at);
  state_.laws.keep_slip_directions(at.v);
  std::vector<char> are_counted(at.has_changed.size(), 0);
  do {
    std::fill(are_counted.begin(), are_counted.end(), 0);
    if (Outcome outcome = search(at, shared_loads, &are_counted); !outcome.ok()) return outcome;
  } while (keep_from_rest(&at));
  return finish(at, are_counted);
}

// ---- putting contacts to rest ----

/// Returns the work -nu'xi_t of the impulses nu [rows] that changed v, J. Guides and belts do it by their own motion.
Power ContactModes::work_of_impulses(const double* r, const std::vector<double>& impulses) const {
  const std::vector<double> nothing(3 * model_.num_points(), 0.0);
  std::vector<double> rates(model_.num_rows());
  work_.constraints.evaluate_rates(model_.parallel, r, nothing.data(), rates.data());
  Power work;
  for (std::size_t a = 0; a < rates.size(); ++a) {
    const bool is_contact = model_.numbering.is_contact_row(a);
    (is_contact ? work.friction : work.supports) -= impulses[a] * rates[a];
  }
  return work;
}

/// Calls change(contact) -> bool for every contact. Returns true if some have changed.
template <class Change>
bool ContactModes::change_some(const Change& change) {
  bool have_changed = false;
  for (std::size_t c = 0; c < state_.size(); ++c) have_changed = change(c) || have_changed;
  if (have_changed) state_.forget_shares();
  return have_changed;
}

/// Lets those contacts slide that count as at rest but move at v more than `times` as fast as the threshold of rest.
/// Returns true if there are any.
bool ContactModes::let_slide(const double* v, double times, ModeSwitch* at) {
  return change_some([&](std::size_t c) {
    const bool is_held = at->at_rest[c] != 0 && at->passes[c] == 0;
    if (!is_held || state_.sliding_speed(c, v) <= times * state_.sliding_threshold(c)) return false;
    at->at_rest[c] = 0;
    state_.let_slide(c);
    return true;
  });
}

/// Holds those contacts no longer that have come to rest just now but are kept from it, as their speed at v tells: it
/// is more than `times` the threshold of rest. They pass through rest, and leave it as their accelerations say. Returns
/// true if there are any.
bool ContactModes::let_pass(const double* v, double times, ModeSwitch* at) {
  return change_some([&](std::size_t c) {
    const bool has_come = at->at_rest[c] != 0 && at->passes[c] == 0 && !state_.places.holds(c);
    if (!has_come || !state_.is_at_rest(c, at->before.data())) return false;
    if (state_.sliding_speed(c, v) <= times * state_.sliding_threshold(c)) return false;
    at->passes[c] = 1;
    state_.tangents.set_stick(c, false);
    return true;
  });
}

/// Lets contacts slide that pass through rest, although by their accelerations they would stay there. Returns true if
/// there are any.
bool ContactModes::keep_from_rest(ModeSwitch* at) {
  return change_some([&](std::size_t c) {
    if (at->passes[c] == 0 || at->at_rest[c] == 0 || !state_.tangents.sticks(c)) return false;
    at->at_rest[c] = 0;
    state_.let_slide(c);
    return true;
  });
}

/// Returns the largest speed at v of a contact that counts as at rest, m/s.
double ContactModes::speed_of_rest(const ModeSwitch& at, const double* v) const {
  double speed = 0.0;
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (at.at_rest[c] != 0) speed = std::max(speed, state_.sliding_speed(c, v));
  }
  return speed;
}

/// Returns true if no point has lost more velocity than a little part of the speed around it (the energy loses its
/// square), or than the speed `own` of the contacts that are put to rest.
bool ContactModes::is_little(const std::vector<double>& before, const double* v, double little, double own) const {
  constexpr double alike = 10.0;
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    const double lost = norm(load(v, i) - load(before.data(), i));
    if (!(lost <= std::max(little * work_.scales.speed(work_.scales.of_point(i)), alike * own))) return false;
  }
  return true;
}

/// Puts all contacts at rest exactly to rest, whatever they do next. On a surface a contact may still move across its
/// slip direction. It is put to rest as well, unless other points would lose more than rounding with it. An example is
/// a bead between two contacts on nearly one line, which moves aside many times as fast as they do. Such a contact
/// slides on in the direction of its motion.
Outcome ContactModes::put_to_rest(ModeSwitch* at) {
  const std::vector<double> before(at->v, at->v + 3 * model_.num_points());
  std::vector<double> impulses(model_.num_rows());
  const Power earlier = work_of_rest_;
  const double own = speed_of_rest(*at, at->v);
  for (const bool is_again : {false, true}) {
    if (Outcome outcome = state_.system.linearise(at->t, at->r); !outcome.ok()) return outcome;
    std::fill(impulses.begin(), impulses.end(), 0.0);
    const ProjectionReport still = state_.system.project_velocities(at->t, at->r, at->v, impulses.data());
    if (!still.outcome.ok()) return still.outcome;
    work_of_rest_ = earlier;
    work_of_rest_.add(1.0, work_of_impulses(at->r, impulses));
    if (is_again || is_little(before, at->v, 1e-6, own)) {
      // Contacts that the constraints keep from rest, such as a bead that only turns others on its line, slide on as
      // well.
      constexpr double rounding_of_rest = 10.0;
      (void)let_pass(at->v, rounding_of_rest, at);
      (void)let_slide(at->v, rounding_of_rest, at);
      return {};
    }
    if (!let_slide(before.data(), 1.0, at) && !let_pass(before.data(), 0.0, at)) return {};
    std::copy(before.begin(), before.end(), at->v);
  }
  return {};
}

/// Contacts that were about to stop are at rest as well if those that were put to rest hold them. Otherwise they slide
/// with the rounding of their velocity, which nothing lowers. Returns true if there are any.
bool ContactModes::bring_along(ModeSwitch* at) {
  return change_some([&](std::size_t c) {
    const bool is_open = at->has_changed[friction_.islands().of_contact[c]] != 0;
    if (!is_open || at->at_rest[c] != 0 || !state_.may_rest(c) || !state_.is_at_rest(c, at->v)) return false;
    at->at_rest[c] = 1;
    state_.tangents.set_stick(c, true);
    return true;
  });
}

/// Slow slip directions are chosen anew, since other contacts may hold them now or hold them no longer.
void ContactModes::forget_slow_directions(const ModeSwitch& at) {
  for (std::size_t c = 0; c < state_.size(); ++c) {
    const bool is_open = at.has_changed[friction_.islands().of_contact[c]] != 0;
    const bool slides = is_open && at.at_rest[c] == 0 && !state_.tangents.sticks(c);
    if (slides && state_.tangents[c].num_guides == 1 && !state_.is_at_rest(c, at.v))
      state_.laws.set_slip_direction(c, {});
  }
}

// ---- the search ----

/// Marks the islands that have changed and have contacts at rest on surfaces, too many to be counted.
std::vector<char> ContactModes::find_many_on_surfaces(const ModeSwitch& at) const {
  const ContactIslands& islands = friction_.islands();
  std::vector<char> result(islands.size(), 0);
  for (std::size_t c = 0; c < state_.size(); ++c) {
    const std::size_t island = islands.of_contact[c];
    const bool are_many = islands.contacts[island].size() > most_contacts_counted;
    if (at.at_rest[c] != 0 && state_.tangents[c].num_tangents() == 2 && are_many)
      result[island] = at.has_changed[island];
  }
  return result;
}

/// Solves islands with many contacts on surfaces first, then all others that are small enough.
Outcome ContactModes::count_islands(const ModeSwitch& at, std::vector<ContactChoice>* choices) {
  constexpr std::size_t most_at_start = 64;
  const bool rest = at.num_at_rest() > 0;
  if (rest) {
    Outcome outcome = count_motions(state_, friction_, at, find_many_on_surfaces(at), unlimited, true, choices);
    if (!outcome.ok()) return outcome;
  }
  if (!rest && !at.is_start()) return {};
  std::vector<char> others = at.has_changed;
  for (const ContactChoice& choice : *choices) others[choice.island] = 0;
  return count_motions(state_, friction_, at, others, at.is_start() ? most_at_start : most_contacts_counted, false,
                       choices);
}

/// Searches for the modes. If pivoting fails, the counted choices are taken as they stand, and then islands of many
/// contacts are solved as a whole. `are_counted` [island] marks islands of which all motions are known.
Outcome ContactModes::search(const ModeSwitch& at, bool shared_loads, std::vector<char>* are_counted) {
  std::vector<ContactChoice> choices;
  Outcome found = count_islands(at, &choices);
  const bool are_listed = found.ok();
  if (are_listed) {
    for (const ContactChoice& choice : choices) (*are_counted)[choice.island] = 1;
    for (const std::size_t c : at.releases) {
      const bool is_counted = (*are_counted)[friction_.islands().of_contact[c]] != 0;
      if (!is_counted && !shared_loads) state_.release(c, state_.system.lambda().data());
    }
    found = find_complementary_modes(state_, at, choices, friction_.islands(), *are_counted);
  }
  const auto may_go_on = [&] { return !found.ok() && found.status != Status::NotUnique; };
  const auto has_more = [](const ContactChoice& choice) { return choice.has_solution() && !choice.has_shared; };
  if (may_go_on() && are_listed && std::any_of(choices.begin(), choices.end(), has_more)) {
    found = take_choices(state_, at, true, &choices);
    if (found.ok()) found = find_complementary_modes(state_, at, choices, friction_.islands(), *are_counted);
  }
  if (may_go_on() && at.num_at_rest() > most_contacts_counted) {
    for (std::size_t c = 0; c < state_.size(); ++c) state_.tangents.set_stick(c, at.at_rest[c] != 0);
    std::vector<char> wanted = at.has_changed;
    for (std::size_t island = 0; island < wanted.size(); ++island)
      wanted[island] = at.has_changed[island] && !(*are_counted)[island];
    const std::size_t before = choices.size();
    const Outcome outcome = count_motions(state_, friction_, at, wanted, unlimited, true, &choices);
    if (outcome.ok() && choices.size() > before)
      found = find_complementary_modes(state_, at, choices, friction_.islands(), *are_counted);
  }
  return found;
}

/// Computes the accelerations of the modes that were found, and verifies them as at the end of a step. Islands in which
/// nothing has changed keep their verdict.
Outcome ContactModes::finish(const ModeSwitch& at, const std::vector<char>& are_counted) {
  std::vector<char> are_open = at.has_changed;
  for (std::size_t island = 0; island < are_open.size(); ++island) {
    const bool rests =
        std::ranges::any_of(friction_.islands().contacts[island], [&](std::size_t c) { return at.at_rest[c] != 0; });
    if (are_counted[island] != 0 || !rests) are_open[island] = 0;
  }
  if (Outcome outcome = verify_uncounted(state_, friction_, at, are_open); !outcome.ok()) return outcome;
  if (Outcome outcome = keep_moving(at); !outcome.ok()) return outcome;
  state_.places.hold(at.t, at.r);
  Request at_end = at.request;
  at_end.gradients = Gradients::Keep;
  Outcome found = state_.system.accelerations({at.t, at.r, at.v}, at_end, are_counted, at.to);
  if (found.ok()) found = check_rest(at);
  if (state_.verdict.uniqueness == Uniqueness::Several) {
    state_.verdict.uniqueness = Uniqueness::Unproven;
    state_.verdict.reason = "several accelerations obeyed the law at t = " + text(at.t);
  }
  return found;
}

/// Projects velocities again where contacts that were put to rest slide on, since other rows hold them from now on. If
/// others have lost speed with them, only what sticks is put to rest. A bead on its line passes through rest where a
/// rod that turns another one is at right angles to the line; to hold it would stop both.
Outcome ContactModes::keep_moving(const ModeSwitch& at) {
  constexpr double rounding = 1e-11;
  bool some_slide = false;
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (at.at_rest[c] == 0 || state_.tangents.sticks(c)) continue;
    if (!state_.is_at_rest(c, at.before.data())) return {};  // it was slow, and begins anew from rest
    some_slide = true;
  }
  if (!some_slide) return {};
  if (!is_little(at.before, at.v, rounding, speed_of_rest(at, at.before.data()))) {
    std::copy(at.before.begin(), at.before.end(), at.v);
    work_of_rest_ = {};
  }
  if (Outcome outcome = state_.system.linearise(at.t, at.r); !outcome.ok()) return outcome;
  std::vector<double> impulses(model_.num_rows(), 0.0);
  const ProjectionReport moving = state_.system.project_velocities(at.t, at.r, at.v, impulses.data());
  work_of_rest_.add(1.0, work_of_impulses(at.r, impulses));
  return moving.outcome;
}

/// Checks that the answer obeys the law, whatever search found it: contacts that stick do not move and hold no more
/// than their limit.
Outcome ContactModes::check_rest(const ModeSwitch& at) const {
  constexpr double largest_miss = 1e-6;
  const double* const lambda = state_.system.lambda().data();
  std::vector<double> rows(model_.num_rows());  // T'w + phi
  work_.constraints.evaluate_contacts(model_.parallel, at.r, at.v, at.to.a, Tangents::Which::All, rows.data());
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (at.at_rest[c] == 0 || !state_.tangents.sticks(c)) continue;
    const double a = norm(state_.laws.along_tangents(c, rows.data()));
    const double scale = state_.system.acceleration_scales()[state_.neighbourhood(c)];
    const double limit = (1.0 + ContactState::overload) * state_.laws.static_limit(c, lambda);
    const double held = state_.held(c, lambda);
    const bool is_still = a <= largest_miss * scale;
    if (is_still && held - limit <= largest_miss * std::max(limit, state_.mass(c) * scale)) continue;
    const auto [holds, most] = texts_apart(std::array{held, limit});
    const Units& units = model_.system.units;
    return fail_friction(Status::NotConverged, at.t,
                         "what was found misses the law: " + work_.name_contact(c) + " sticks, and " +
                             (is_still ? "holds " + holds + " of at most " + with_unit(most, units.force)
                                       : "moves by " + with_unit(text(a), units.letters(Dimension::Acceleration))));
  }
  return {};
}

// ---- from step to step ----

/// Places that other constraints keep from being reached give way, since those constraints hold the contact as well.
void ContactModes::accept(double t, const double* r, const double* v) {
  if (num_events() > 0) {
    state_.places.accept(t);
    if (state_.shares_loads || state_.system.redundancy().is_found()) state_.places.give_way(r);
  }
  state_.set_sliding_speeds();
  state_.laws.keep_slip_directions(v);
}

void ContactModes::exchange_memory(Memory& memory) {
  bool shares_loads = state_.shares_loads;
  memory.exchange(shares_loads, state_.verdict.uniqueness);
  if (memory.reads()) {
    state_.forget_shares();
    if (shares_loads) (void)state_.begin_sharing();
  }
  state_.places.exchange_memory(memory);
  friction_.exchange_memory(memory);
}

}  // namespace tanor::detail
