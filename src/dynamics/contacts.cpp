#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "dynamics/held_friction.hpp"
#include "dynamics/normal_form.hpp"

/// \file Contacts of NormalForm that stick and slide (theory, section 7a): exact Coulomb friction as events.
///
/// A contact sticks as long as |lambda_t| <= mu_s |N|, and slides until its sliding velocity vanishes. At rest the law
/// holds on the acceleration level: lambda_t in -mu_s |N| Sgn(a_t).
namespace tanor {

Outcome NormalForm::begin(double t, const double* r, double* v, double* w) {
  const bool depends_on_reactions = friction_ != nullptr && friction_->laws().depend_on_reactions();
  return depends_on_reactions ? settle_contacts(t, r, v, w) : accelerations(t, r, v, Gradients::Evaluate, w);
}

/// Held this much above the limit, relative, is held at it: the rounding of multipliers.
static constexpr double limit_slack = 1e-12;

/// Sliding backwards no faster than this, over the speed of its neighbourhood, is the rounding of a start from rest.
static constexpr double speed_slack = 1e-13;

/// The speed beside which sliding there is slow, and the acceleration: those of its own neighbourhood.
double NormalForm::speed_at(std::size_t contact) const {
  const auto point = static_cast<std::size_t>(model_.constraints.tangents()[contact].point);
  return model_.scales.speed(model_.scales.of_point(point));
}
double NormalForm::acceleration_at(std::size_t contact) const {
  const auto point = static_cast<std::size_t>(model_.constraints.tangents()[contact].point);
  return accelerations_[model_.scales.of_point(point)];
}

/// Sliding slower than this is rest: the rounding of projected velocities.
double NormalForm::sliding_threshold(std::size_t contact) const {
  return 1e-11 * speed_at(contact);
}

/// Other contacts stick than before: whether they hold too much is to be found anew.
void NormalForm::forget_compliance() {
  is_compliant_ = false;
  general().set_compliance(0.0);
}

/// What sticks may hold more than can move, and then no law divides the load: the least friction that holds. A little
/// compliance finds it, refinement removes the compliance (refined solutions lie in the range of S). Returns whether S
/// is to be factorized anew.
bool NormalForm::make_compliant() {
  if (friction_ == nullptr || is_compliant_ || friction_->num_sticking() == 0) return false;
  is_compliant_ = true;
  std::vector<double> weights(num_rows() - model_.numbering.num_user_rows, 1.0);
  const Tangents& tangents = model_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    for (int k = 0; place.first_row >= 0 && !softness_.empty() && k < place.num_tangents(); ++k) {
      const auto row =
          static_cast<std::size_t>(model_.numbering.user_row[static_cast<std::size_t>(place.first_row + k)]);
      weights[row - model_.numbering.num_user_rows] = std::exp2(-static_cast<double>(softness_[c]) / softness_steps);
    }
  }
  general().set_compliance(compliance, std::move(weights));
  return true;
}

/// Contacts that have references hold more than can move.
bool NormalForm::shares_a_load() const {
  const Tangents& tangents = model_.constraints.tangents();
  for (std::size_t c = 0; num_switches_ > 0 && c < tangents.size(); ++c) {
    if (tangents.sticks(c) && norm(friction_->laws().reference(c)) > 0.0) return true;
  }
  return false;
}

/// Contacts that share a load: each gives way the more, the nearer it is to its limit (Lawson's algorithm for the share
/// in which the most loaded contact has most to spare). `loads` [contact]: of those that stick, held over limit; else
/// negative.
void NormalForm::share_again(const std::vector<double>& loads) {
  softness_.resize(loads.size(), 0);
  constexpr double least_load = 0.05;
  constexpr int hardest = 12 * softness_steps;
  int softest = hardest;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] < 0.0) continue;
    const double load = std::max(least_load, std::min(loads[c], 1.0 / least_load));
    softness_[c] -= static_cast<int>(std::lround(2.0 * softness_steps * std::log2(load)));
    softest = std::min(softest, softness_[c]);
  }
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] >= 0.0) softness_[c] = std::clamp(softness_[c] - softest, 0, hardest);
    if (!model_.constraints.tangents().sticks(c)) softness_[c] = 0;
  }
  forget_compliance();
}

/// K as far as its rank is a question: contacts take no part.
std::vector<double> NormalForm::blocks_of_constraints() const {
  return num_switches_ > 0 ? model_.without_contacts(blocks_) : blocks_;
}

void NormalForm::set_sliding_speeds() {
  constexpr double slow = 3e-7;
  for (std::size_t c = 0; c < model_.constraints.tangents().size(); ++c)
    friction_->laws().set_speeds(c, sliding_threshold(c), slow * speed_at(c));
}

void NormalForm::evaluate_events(double, const double*, const double* v, double* values) {
  const Tangents& tangents = model_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (tangents[c].first_row < 0) continue;
    if (tangents.sticks(c)) {
      const double limit = limit_factor(c) * static_limit(friction_->laws(), c, lambda_.data());
      const double held = norm(held_friction(tangents, friction_->laws(), c, lambda_.data()));
      *values++ = limit + held > 0.0 ? (limit - held) / (limit + held) + 2.0 * limit_slack : 1.0;
    } else {
      const double forward = dot(tangents.sliding_velocity(c, v), friction_->laws().sense(c));
      *values++ = forward / speed_at(c) + speed_slack;
    }
  }
}

/// limit^2 - held^2, with mu^2 |N|^2 and |F|^2 quadratic in the multipliers.
void NormalForm::shape_events(const double* values, double* shapes) const {
  const Tangents& tangents = model_.constraints.tangents();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (tangents[c].first_row < 0) continue;
    const double value = *values++;
    if (tangents.sticks(c)) {
      const double limit = limit_factor(c) * static_limit(friction_->laws(), c, lambda_.data());
      const double held = norm(held_friction(tangents, friction_->laws(), c, lambda_.data()));
      const double slack = 2.0 * limit_slack * (limit + held);
      *shapes++ = (limit - held + slack) * (limit + held);
    } else {
      *shapes++ = value;
    }
  }
}

Outcome NormalForm::settle_contacts(double t, const double* r, double* v, double* w) {
  Tangents& tangents = model_.constraints.tangents();
  std::vector<char> at_rest(tangents.size(), 0);
  for (std::size_t c = 0; c < tangents.size(); ++c) tangents.set_stick(c, false);
  held_->forget();
  if (Outcome outcome = linearise(t, r); !outcome.ok()) return outcome;
  set_sliding_speeds();
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    at_rest[c] = tangents[c].first_row >= 0 && norm(tangents.sliding_velocity(c, v)) <= sliding_threshold(c);
    tangents.set_stick(c, at_rest[c] != 0);
    friction_->laws().set_sense(c, {});
  }
  friction_->laws().keep_senses(v);
  verdict_ = Uniqueness::NotAsked;
  softness_.clear();
  overloads_.clear();
  std::fill(lambda_.begin(), lambda_.end(), 0.0);
  const std::vector<char> all_islands(friction_->islands().size(), 1);
  return choose_modes(t, r, v, at_rest, {}, all_islands, w);
}

Outcome NormalForm::switch_equations(double t, const double* r, double* v, std::span<const std::size_t> which,
                                     double* w) {
  Tangents& tangents = model_.constraints.tangents();
  std::vector<char> at_rest(tangents.size(), 0), is_met(num_switches_, 0), has_changed(friction_->islands().size(), 0);
  for (const std::size_t event : which) is_met[event] = 1;
  std::vector<std::size_t> releases;
  std::size_t event = 0;
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (tangents[c].first_row < 0) continue;
    const bool is_now = is_met[event++] != 0;
    if (is_now) has_changed[friction_->islands().of_contact[c]] = 1;
    if (tangents.sticks(c)) {
      at_rest[c] = 1;
      if (is_now) releases.push_back(c);
    } else if (is_now || norm(tangents.sliding_velocity(c, v)) <= sliding_threshold(c)) {
      at_rest[c] = 1;
      tangents.set_stick(c, true);
      has_changed[friction_->islands().of_contact[c]] = 1;
    }
  }
  return choose_modes(t, r, v, at_rest, releases, has_changed, w);
}

/// Islands with contacts at rest on surfaces that are too many to be counted, among those that are `wanted`.
std::vector<char> NormalForm::find_many_on_surfaces(const std::vector<char>& at_rest,
                                                    const std::vector<char>& wanted) const {
  const Tangents& tangents = model_.constraints.tangents();
  std::vector<char> result(wanted.size(), 0);
  for (std::size_t c = 0; c < at_rest.size(); ++c) {
    const std::size_t island = friction_->islands().of_contact[c];
    const bool are_many = friction_->islands().contacts[island].size() > most_contacts_counted;
    if (at_rest[c] != 0 && tangents[c].num_tangents() == 2 && are_many) result[island] = wanted[island];
  }
  return result;
}

/// Of multipliers nu [rows] that changed v at once, J: -nu'xi_t, with what guides and belts move by themselves.
Power NormalForm::work_of_impulses(const double* r, const double* v, const std::vector<double>& impulses) {
  std::vector<double> prescribed(v, v + size()), rates(num_rows());
  std::fill(prescribed.begin(), prescribed.end(), 0.0);
  model_.constraints.evaluate_rates(model_.parallel, r, prescribed.data(), rates.data());
  Power work;
  for (std::size_t a = 0; a < num_rows(); ++a) {
    const bool is_contact = static_cast<std::size_t>(model_.numbering.user_row[a]) >= model_.numbering.num_user_rows;
    (is_contact ? work.friction : work.supports) -= impulses[a] * rates[a];
  }
  return work;
}

/// All at rest are at rest exactly, whatever they do next. On a surface a contact may still move across its sense: it
/// is put to rest, too, unless others would lose more than rounding with it, such as a bead between two contacts on
/// nearly one line, which moves aside many times as fast as they. Then it slides on, to where it moves.
Outcome NormalForm::put_to_rest(double t, const double* r, double* v, std::vector<char>* at_rest) {
  // Of the speed around (the energy loses its square), or of what is put to rest itself.
  constexpr double little = 1e-6, alike = 10.0;
  Tangents& tangents = model_.constraints.tangents();
  const std::vector<double> before(v, v + size());
  std::vector<double> impulses(num_rows());
  double own = 0.0;
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if ((*at_rest)[c] != 0) own = std::max(own, norm(tangents.sliding_velocity(c, v)));
  }
  for (const bool is_again : {false, true}) {
    if (Outcome outcome = linearise(t, r); !outcome.ok()) return outcome;
    std::fill(impulses.begin(), impulses.end(), 0.0);
    const ProjectionReport still = iterate_onto_velocities(t, r, v, impulses.data());
    if (!still.outcome.ok()) return still.outcome;
    work_of_rest_ = work_of_impulses(r, v, impulses);
    bool is_little = true;
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      const double lost = norm(load(v, i) - load(before.data(), i));
      is_little = is_little && lost <= std::max(little * model_.scales.speed(model_.scales.of_point(i)), alike * own);
    }
    if (is_little || is_again) {
      // What constraints do not let be put to rest, such as a bead that only turns others on its line, slides on, too.
      constexpr double rounding_of_rest = 10.0;
      for (std::size_t c = 0; c < tangents.size(); ++c) {
        const double left = norm(tangents.sliding_velocity(c, v));
        if ((*at_rest)[c] == 0 || left <= rounding_of_rest * sliding_threshold(c)) continue;
        (*at_rest)[c] = 0;
        tangents.set_stick(c, false);
        friction_->laws().set_sense(c, {});
        forget_compliance();
      }
      return {};
    }
    bool has_left = false;
    for (std::size_t c = 0; c < tangents.size(); ++c) {
      if ((*at_rest)[c] == 0 || norm(tangents.sliding_velocity(c, before.data())) <= sliding_threshold(c)) continue;
      (*at_rest)[c] = 0;
      tangents.set_stick(c, false);
      friction_->laws().set_sense(c, {});
      has_left = true;
    }
    if (!has_left) return {};
    std::copy(before.begin(), before.end(), v);
    forget_compliance();
  }
  return {};
}

/// The modes of all contacts at rest together. Islands of few contacts are counted as a whole; what they choose, or, of
/// more contacts, that all stick but `releases`, is where the search begins. Where it leads nowhere, islands of many
/// contacts are solved as a whole, too. `has_changed` [island]: where something is to be chosen.
Outcome NormalForm::choose_modes(double t, const double* r, double* v, std::vector<char> at_rest,
                                 const std::vector<std::size_t>& releases, const std::vector<char>& has_changed,
                                 double* w) {
  Tangents& tangents = model_.constraints.tangents();
  work_of_rest_ = {};
  const bool was_compliant = is_compliant_;
  forget_compliance();
  if (std::count(at_rest.begin(), at_rest.end(), 1) > 0) {
    if (Outcome outcome = put_to_rest(t, r, v, &at_rest); !outcome.ok()) return outcome;
  }
  const std::size_t num_at_rest = static_cast<std::size_t>(std::count(at_rest.begin(), at_rest.end(), 1));
  // Slow directions begin anew: others hold them now, or no longer.
  for (std::size_t c = 0; c < at_rest.size(); ++c) {
    const bool moves = at_rest[c] == 0 && has_changed[friction_->islands().of_contact[c]] != 0 && !tangents.sticks(c);
    if (moves && tangents[c].num_guides == 1 && norm(tangents.sliding_velocity(c, v)) > sliding_threshold(c))
      friction_->laws().set_sense(c, {});
  }
  friction_->laws().keep_senses(v);

  constexpr std::size_t most_at_start = 64, unlimited = std::numeric_limits<std::size_t>::max();
  std::vector<ContactChoice> choices;
  Outcome found;
  const auto count = [&](const std::vector<char>& wanted, std::size_t most_contacts, bool takes_all) {
    std::vector<ContactChoice> counted;
    Outcome outcome = count_choices(t, r, v, at_rest, releases, wanted, most_contacts, &counted);
    if (outcome.ok()) outcome = take_choices(t, r, at_rest, takes_all, &counted);
    if (takes_all) std::erase_if(counted, [](const auto& choice) { return !choice.has_shared; });
    choices.insert(choices.end(), std::make_move_iterator(counted.begin()), std::make_move_iterator(counted.end()));
    return outcome;
  };
  if (num_at_rest > 0) found = count(find_many_on_surfaces(at_rest, has_changed), unlimited, true);
  if (found.ok() && (num_at_rest > 0 || is_start())) {
    std::vector<char> others = has_changed;
    for (const ContactChoice& choice : choices) others[choice.island] = 0;
    found = count(others, is_start() ? most_at_start : most_contacts_counted, false);
  }
  const auto is_counted = [&](std::size_t island) {
    return std::any_of(choices.begin(), choices.end(), [&](const auto& choice) { return choice.island == island; });
  };
  std::vector<char> are_counted(has_changed.size(), 0);
  const auto settle = [&] {
    // Several sizes of friction are no several motions in islands that were counted.
    const UniquenessCheck check{false, check_.refuses_several, are_counted};
    return settle_modes(t, r, v, at_rest, releases, has_changed, choices, check, w);
  };
  bool has_searched = false;
  if (found.ok()) {
    has_searched = true;
    for (const ContactChoice& choice : choices) are_counted[choice.island] = 1;
    for (const std::size_t c : releases) {
      if (!is_counted(friction_->islands().of_contact[c]) && !was_compliant) release(c);
    }
    found = settle();
  }
  // Where the search leads nowhere, what was counted stands as it is.
  const auto has_more = [](const ContactChoice& choice) { return choice.x.size() > 0 && !choice.has_shared; };
  if (!found.ok() && has_searched && found.status != Status::NotUnique &&
      std::any_of(choices.begin(), choices.end(), has_more)) {
    found = take_choices(t, r, at_rest, true, &choices);
    if (found.ok()) found = settle();
  }
  if (!found.ok() && found.status != Status::NotUnique && num_at_rest > most_contacts_counted) {
    for (std::size_t c = 0; c < at_rest.size(); ++c) tangents.set_stick(c, at_rest[c] != 0);
    std::vector<char> wanted = has_changed;
    for (std::size_t island = 0; island < wanted.size(); ++island)
      wanted[island] = has_changed[island] && !are_counted[island];
    const std::size_t before = choices.size();
    Outcome outcome = count(wanted, unlimited, true);
    if (outcome.ok() && choices.size() > before) found = settle();
  }
  if (!found.ok()) return found;
  // Islands in which nothing has changed keep their verdict.
  std::vector<char> are_open = has_changed;
  for (std::size_t island = 0; island < are_open.size(); ++island) {
    const auto& contacts = friction_->islands().contacts[island];
    const bool rests = std::any_of(contacts.begin(), contacts.end(), [&](std::size_t c) { return at_rest[c] != 0; });
    if (are_counted[island] != 0 || !rests) are_open[island] = 0;
  }
  if (found = judge_many(t, r, v, at_rest, are_open); !found.ok()) return found;
  held_->hold(t, r);
  const UniquenessCheck check{check_.is_wanted, check_.refuses_several, are_counted};  // as at a step's end
  found = accelerations(t, r, v, Gradients::Keep, check, w);
  if (found.ok()) last_.outcome = found = check_rest(t, r, v, w, at_rest);
  if (verdict_ == Uniqueness::Several) {
    verdict_ = Uniqueness::Unproven;
    verdict_reason_ = "several accelerations obeyed the law at t = " + text(t);
  }
  return found;
}

/// What is given as an answer obeys the law, whatever was searched: contacts that stick do not move, and hold what they
/// can.
Outcome NormalForm::check_rest(double t, const double* r, const double* v, const double* w,
                               const std::vector<char>& at_rest) {
  constexpr double largest_miss = 1e-6;
  const Tangents& tangents = model_.constraints.tangents();
  model_.constraints.evaluate_contacts(model_.parallel, r, v, w, Tangents::Which::All, contact_rows_.data());
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (at_rest[c] == 0 || !tangents.sticks(c)) continue;
    double a = 0.0;
    for (int k = 0; k < tangents[c].num_tangents(); ++k)
      a = larger(a, std::abs(contact_rows_[static_cast<std::size_t>(tangents[c].first_row + k)]));
    const double scale = acceleration_at(c), mass = model_.mass[static_cast<std::size_t>(tangents[c].point)];
    const double limit = (1.0 + overload) * static_limit(friction_->laws(), c, lambda_.data());
    const double held = norm(held_friction(tangents, friction_->laws(), c, lambda_.data()));
    if (a <= largest_miss * scale && held - limit <= largest_miss * std::max(limit, mass * scale)) continue;
    return {Status::NotConverged,
            "friction at t = " + text(t) + ": what was found misses the law: " + model_.name_contact(c) +
                " sticks, and " +
                (a <= largest_miss * scale ? "holds " + text(held) + " N of at most " + text(limit)
                                           : "moves by " + text(a) + " m/s^2")};
  }
  return {};
}

/// Against what held it.
void NormalForm::release(std::size_t c) {
  Tangents& tangents = model_.constraints.tangents();
  const Vec3 held = held_friction(tangents, friction_->laws(), c, lambda_.data());
  const double size = norm(held);
  friction_->laws().set_sense(c, size > 0.0 ? (-1.0 / size) * held : tangents.directions(c)[0]);
  tangents.set_stick(c, false);
}

/// Contacts that stick and cannot are released against what held them, and what does not slide off then is held again,
/// until all obey the law (block pivoting), in the islands that are `wanted`. `choices`: those that were solved as a
/// whole; what has shared a load stands as it is.
Outcome NormalForm::settle_modes(double t, const double* r, const double* v, const std::vector<char>& at_rest,
                                 const std::vector<std::size_t>& releases, const std::vector<char>& wanted,
                                 const std::vector<ContactChoice>& choices, const UniquenessCheck& check, double* w) {
  Tangents& tangents = model_.constraints.tangents();
  FrictionLaws& laws = friction_->laws();
  const std::size_t num_at_rest = static_cast<std::size_t>(std::count(at_rest.begin(), at_rest.end(), 1));
  constexpr std::size_t most_passes = 40;
  constexpr double rounding_of_accelerations = 1e-9;
  std::vector<char> released(tangents.size(), 0);
  // Directions that were solved for: where accelerations are small, to follow them would lead away.
  std::vector<char> is_solved(tangents.size(), 0), is_known(tangents.size(), 0);
  for (const ContactChoice& choice : choices) {
    for (const std::size_t c : choice.members) {
      is_solved[c] = choice.x.size() > 0;
      is_known[c] = choice.has_shared;
    }
  }
  // Others share their load anew.
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    if (wanted[friction_->islands().of_contact[c]] != 0 && is_known[c] == 0) laws.set_reference(c, {});
  }
  constexpr int most_shares = 20;
  constexpr double enough_to_spare = 0.9;
  std::vector<double> loads(tangents.size(), -1.0);
  double last_load = std::numeric_limits<double>::infinity();
  int num_shares = 0;
  bool has_given_way = false, set_limits_once = false;
  for (std::size_t pass = 0; pass < most_passes; ++pass) {
    if (Outcome outcome = accelerations(t, r, v, Gradients::Evaluate, check, w); !outcome.ok()) return outcome;
    if (num_at_rest == 0) return {};
    model_.constraints.evaluate_contacts(model_.parallel, r, v, w, Tangents::Which::All, contact_rows_.data());
    bool has_changed = false, has_reached_limit = false;
    std::vector<std::pair<double, std::size_t>> too_much;  // how far above the limit, relative
    for (std::size_t c = 0; c < tangents.size(); ++c) {
      if (at_rest[c] == 0 || is_known[c] != 0) continue;
      const double scale = acceleration_at(c);
      if (tangents.sticks(c)) {
        const double limit = limit_factor(c) * static_limit(friction_->laws(), c, lambda_.data());
        const double held = norm(held_friction(tangents, friction_->laws(), c, lambda_.data()));
        const double rounding = 1e-13 * scale * model_.mass[static_cast<std::size_t>(tangents[c].point)];
        if (held - (1.0 + limit_slack) * limit > rounding) too_much.emplace_back((held - limit) / held, c);
        continue;
      }
      // a_t must point where it slides to
      Vec3 a{};
      for (int k = 0; k < tangents[c].num_tangents(); ++k)
        a = a + contact_rows_[static_cast<std::size_t>(tangents[c].first_row + k)] *
                    tangents.directions(c)[static_cast<std::size_t>(k)];
      const double along = dot(a, laws.direction(c)), size = norm(a);
      if (along < -rounding_of_accelerations * scale) {
        if (released[c] >= 4) {
          return {Status::NoSolution, "friction at t = " + text(t) + ": " + model_.name_contact(c) +
                                          " can neither stick nor slide; the velocity would have to jump"};
        }
        tangents.set_stick(c, true);
        has_changed = true;
        continue;
      }
      // Others that stick may hold it where it is: then it bears all that it can, before it bears less in sliding.
      const bool is_held = along <= rounding_of_accelerations * scale;
      if (is_held != laws.is_at_limit(c) && laws.static_coefficient(c) > laws.coefficient_of_sliding(c)) {
        laws.set_at_limit(c, is_held);
        has_changed = has_reached_limit = true;
      }
      if (is_solved[c] == 0 && tangents[c].num_guides == 1 && size > rounding_of_accelerations * scale &&
          along < (1.0 - 1e-13) * size) {
        laws.set_sense(c, (1.0 / size) * a);  // on a surface the direction is a part of the answer
        has_changed = has_changed || along < (1.0 - 1e-12) * size;
      }
    }
    // Those that share a load may share it otherwise.
    double worst_load = -1.0;
    for (std::size_t c = 0; is_compliant_ && c < tangents.size(); ++c) {
      const bool is_open = is_known[c] == 0 && wanted[friction_->islands().of_contact[c]] != 0;
      const bool counts = at_rest[c] != 0 && tangents.sticks(c) && is_open;
      const double limit = counts ? static_limit(friction_->laws(), c, lambda_.data()) : 0.0;
      loads[c] = !counts       ? -1.0
                 : limit > 0.0 ? norm(held_friction(tangents, friction_->laws(), c, lambda_.data())) / limit
                               : 1.0;
      if (limit > 0.0) worst_load = std::max(worst_load, loads[c]);
    }
    const bool is_asked = !too_much.empty() || num_shares > 0 || (pass == 0 && !releases.empty());
    if (is_asked && worst_load > enough_to_spare && num_shares < most_shares && worst_load < 0.99 * last_load) {
      ++num_shares;
      last_load = worst_load;
      share_again(loads);
      continue;
    }
    last_load = 0.0;
    // No share leaves them anything to spare: they give way together.
    for (std::size_t c = 0; c < tangents.size(); ++c) {
      if (!is_compliant_ || has_given_way || releases.empty() || loads[c] < 1.0 - 1e-8) continue;
      if (is_known[c] != 0) continue;
      release(c);
      has_changed = true;
    }
    has_given_way = true;
    if (!set_limits_once && !too_much.empty()) {
      set_limits_once = true;
      if (set_limits(choices)) continue;
    }
    // Many at once while that goes well, then one by one.
    constexpr std::size_t passes_at_once = 10;
    double worst = 0.0;
    for (const auto& [excess, contact] : too_much) worst = std::max(worst, excess);
    for (const auto& [excess, contact] : too_much) {
      if (has_reached_limit || excess < (pass < passes_at_once ? 0.5 : 1.0) * worst) continue;
      ++released[contact];
      release(contact);
      for (std::size_t other = 0; other < at_rest.size(); ++other) laws.set_at_limit(other, false);
      has_changed = true;
    }
    // Those whose event was located a rounding below their limit, or that hold a rounding more, give way, too: else
    // they would be met again at once.
    for (std::size_t c = 0; !has_changed && !releases.empty() && c < tangents.size(); ++c) {
      const bool is_open = at_rest[c] != 0 && tangents.sticks(c) && wanted[friction_->islands().of_contact[c]] != 0;
      if (!is_open || is_known[c] != 0 || released[c] != 0) continue;
      const bool is_met = std::find(releases.begin(), releases.end(), c) != releases.end();
      const double limit =
          (is_met ? 1.0 - 1e-8 : 1.0 + limit_slack) * static_limit(friction_->laws(), c, lambda_.data());
      if (!(norm(held_friction(tangents, friction_->laws(), c, lambda_.data())) >= limit)) continue;
      ++released[c];
      release(c);
      has_changed = true;
    }
    if (!has_changed) return {};
    std::fill(is_solved.begin(), is_solved.end(), 0);
  }
  return {Status::NotConverged, "friction at t = " + text(t) +
                                    ": no choice of which contacts stick and which slide obeys the law for all of " +
                                    text(static_cast<double>(num_at_rest)) + " at rest"};
}

// ---- where contacts that stick are held ----

/// Largest |T'(r - place)| in `rows_` over the length around it, where the row is one of those that decide.
double NormalForm::held_violation() const {
  const Tangents& tangents = model_.constraints.tangents();
  double worst = 0.0;
  for (std::size_t c = 0; !is_compliant_ && c < tangents.size(); ++c) {
    if (!tangents.sticks(c) || !held_->holds(c)) continue;
    const double length = model_.scales.length(model_.scales.of_point(static_cast<std::size_t>(tangents[c].point)));
    for (int k = 0; k < tangents[c].num_tangents(); ++k) {
      const auto row = static_cast<std::size_t>(tangents[c].first_row + k);
      if (!redundancy_.is_dependent(row)) worst = larger(worst, std::abs(rows_[row]) / length);
    }
  }
  return worst;
}

/// A step to t was accepted. What other constraints do not let be where it is held gives way: they hold it as well.
void NormalForm::accept_places(double t, const double* r) {
  held_->accept(t);
  const Tangents& tangents = model_.constraints.tangents();
  for (std::size_t c = 0; (is_compliant_ || redundancy_.is_found()) && c < tangents.size(); ++c) {
    constexpr double given_way = 1e-12;
    if (!tangents.sticks(c) || !held_->holds(c)) continue;
    const auto point = static_cast<std::size_t>(tangents[c].point);
    const Vec3 away = load(r, point) - held_->place(c);
    double along = 0.0;
    for (int k = 0; k < tangents[c].num_tangents(); ++k)
      along = std::max(along, std::abs(dot(tangents.directions(c)[static_cast<std::size_t>(k)], away)));
    if (along > given_way * model_.scales.length(model_.scales.of_point(point))) held_->move(c, r);
  }
}

// ---- the discrete state: one number a contact ----

namespace {

enum Mode : int {
  slides = 0,
  sticks = 1,
  slides_forward = 2,
  slides_backward = 3,
  at_limit = 2,
  overloaded = 6,
  num_modes = 7
};  // 4, 5: both

}  // namespace

/// On a curve the sense of sliding is kept too, as its sign along T: at rest the velocity does not tell it. And how a
/// load is shared, in multiples of the number of modes.
std::vector<int> NormalForm::discrete_state() const {
  const Tangents& tangents = model_.constraints.tangents();
  std::vector<int> state;
  for (std::size_t c = 0; num_switches_ > 0 && c < tangents.size(); ++c) {
    const double along = dot(friction_->laws().sense(c), tangents.directions(c)[0]);
    state.push_back(tangents.sticks(c)                            ? sticks
                    : tangents[c].num_guides == 1 || along == 0.0 ? slides
                    : along > 0.0                                 ? slides_forward
                                                                  : slides_backward);
    if (state.back() > sticks && friction_->laws().is_at_limit(c)) state.back() += at_limit;
    if (limit_factor(c) > 1.0) state.back() = overloaded;
    if (!softness_.empty()) state.back() += num_modes * softness_[c];
  }
  return state;
}

void NormalForm::restore_discrete_state(std::span<const int> state) {
  Tangents& tangents = model_.constraints.tangents();
  const std::size_t wanted = num_switches_ > 0 ? tangents.size() : 0;
  if (state.size() != wanted) {
    throw InputError("/snapshot/discrete_state", std::to_string(state.size()) + " modes for " + std::to_string(wanted) +
                                                     " contacts that may stick");
  }
  restored_.assign(state.begin(), state.end());
  softness_.assign(state.size(), 0);
  overloads_.assign(state.size(), 0);
  for (std::size_t c = 0; c < state.size(); ++c) {
    softness_[c] = std::max(0, state[c] / num_modes);
    restored_[c] -= num_modes * softness_[c];
    if (restored_[c] == overloaded) {
      overloads_[c] = 1;
      restored_[c] = sticks;
    }
    tangents.set_stick(c, restored_[c] == sticks);
  }
}

/// Where T stands again.
void NormalForm::restore_senses(const double* r, const double* v) {
  if (restored_.empty()) return;
  held_->hold(model_.time(), r);
  FrictionLaws& laws = friction_->laws();
  set_sliding_speeds();
  for (std::size_t c = 0; c < restored_.size(); ++c) {
    const Vec3 t = model_.constraints.tangents().directions(c)[0];
    const bool is_at_limit = restored_[c] > slides_backward;
    const int mode = is_at_limit ? restored_[c] - at_limit : restored_[c];
    laws.set_sense(c, mode == slides_forward ? t : mode == slides_backward ? -t : Vec3{});
    laws.set_at_limit(c, is_at_limit);
  }
  laws.keep_senses(v);
  restored_.clear();
}

}  // namespace tanor
