#include "friction/mode_pivoting.hpp"

#include <algorithm>

#include "base/text.hpp"

namespace tanor::detail {

/// The state of one search for the modes, and the findings of its last pass.
struct ModePivoting::Search {
  const ModeSwitch& at;
  std::vector<char> is_open{};    // [contact] at rest, and without a share that is known
  std::vector<char> may_share{};  // [contact] the same, of islands that have changed
  std::vector<char> is_solved{};  // [contact] its slip direction was solved for, so small accelerations keep it
  std::vector<int> released{};    // [contact] how often
  std::vector<double> loads{};    // [contact] held over limit if it sticks; otherwise negative
  double last_load = std::numeric_limits<double>::infinity();  // the largest one at the last change of shares
  std::size_t pass = 0;
  int num_shares = 0;
  bool has_given_way = false, has_set_limits = false;
  // The members below belong to the present pass.
  bool has_changed = false, has_reached_limit = false;
  std::vector<std::pair<double, std::size_t>> too_much{};  // relative excess over the limit; contact
};

ModePivoting::Search ModePivoting::begin(const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                                         const ContactIslands& islands) const {
  Search search{.at = at};
  search.is_open = at.at_rest;
  search.is_solved.assign(state_.size(), 0);
  search.released.assign(state_.size(), 0);
  search.loads.assign(state_.size(), -1.0);
  std::vector<char> is_known(state_.size(), 0);
  for (const ContactChoice& choice : choices) {
    for (const std::size_t c : choice.members) {
      search.is_solved[c] = choice.has_solution();
      is_known[c] = choice.has_shared;
    }
  }
  search.may_share.assign(state_.size(), 0);
  for (std::size_t c = 0; c < state_.size(); ++c) {
    const bool may_change = at.has_changed[islands.of_contact[c]] != 0 && is_known[c] == 0;
    if (is_known[c] != 0) search.is_open[c] = 0;
    search.may_share[c] = may_change && at.at_rest[c] != 0;
    // The other contacts share their load anew.
    if (may_change) state_.laws.set_reference(c, {});
  }
  return search;
}

Outcome ModePivoting::find_complementary_modes(const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                                               const ContactIslands& islands, std::span<const char> are_counted) {
  constexpr std::size_t most_passes = 40;
  Search search = begin(at, choices, islands);
  Request on_the_way = at.request;
  on_the_way.gradients = Gradients::Evaluate;
  on_the_way.verification = Verification::None;
  const AccelerationOutput on_the_way_to{at.to.a, nullptr, at.to.report};
  const std::size_t num_at_rest = at.num_at_rest();
  for (; search.pass < most_passes; ++search.pass) {
    Outcome outcome = state_.system.accelerations({at.t, at.r, at.v}, on_the_way, are_counted, on_the_way_to);
    if (!outcome.ok() || num_at_rest == 0) return outcome;
    if (outcome = look(&search); !outcome.ok()) return outcome;
    if (share_otherwise(&search)) continue;
    give_way_together(&search);
    if (!search.has_set_limits && !search.too_much.empty()) {
      search.has_set_limits = true;
      if (choices_.set_limits(choices)) continue;
    }
    release_worst(&search);
    release_met(&search);
    if (!search.has_changed) return {};
    std::fill(search.is_solved.begin(), search.is_solved.end(), 0);
  }
  return fail_friction(Status::NotConverged, at.t,
                       "no choice of which contacts stick and which slide obeys the law for all of " +
                           text(static_cast<double>(num_at_rest)) + " at rest");
}

/// Finds, at the last accelerations, the sticking contacts that hold too much and the sliding contacts that move
/// backwards. The latter stick again.
Outcome ModePivoting::look(Search* search) const {
  constexpr int most_releases = 4;
  const ModeSwitch& at = search->at;
  Workspace& work = state_.work;
  const Model& model = state_.model;
  Tangents& tangents = state_.tangents;
  const double* const lambda = state_.system.lambda().data();
  std::vector<double> rows(model.num_rows());  // T'w + phi
  work.constraints.evaluate_contacts(model.parallel, at.r, at.v, at.to.a, Tangents::Which::All, rows.data());
  search->has_changed = search->has_reached_limit = false;
  search->too_much.clear();
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (search->is_open[c] == 0) continue;
    const double scale = state_.system.acceleration_scales()[state_.neighbourhood(c)];
    if (tangents.sticks(c)) {
      const double limit = state_.limit(c, lambda), held = state_.held(c, lambda);
      const double rounding = 1e-13 * scale * state_.mass(c);
      if (held - (1.0 + limit_slack) * limit > rounding) search->too_much.emplace_back((held - limit) / held, c);
      continue;
    }
    Vec3 a{};
    for (int k = 0; k < tangents[c].num_tangents(); ++k)
      a = a + rows[static_cast<std::size_t>(tangents[c].first_row + k)] *
                  tangents.directions(c)[static_cast<std::size_t>(k)];
    // A sliding contact must accelerate along its slip direction.
    if (!(dot(a, state_.laws.direction(c)) < -rounding_of_accelerations * scale)) {
      look_at_sliding(c, a, search);
      continue;
    }
    if (search->released[c] >= most_releases) {
      return fail_friction(Status::NoSolution, at.t,
                           work.name_contact(c) + " can neither stick nor slide; the velocity would have to jump");
    }
    tangents.set_stick(c, true);
    search->has_changed = true;
  }
  return {};
}

/// Updates the limit and the slip direction of a contact that begins to slide with the acceleration a.
void ModePivoting::look_at_sliding(std::size_t c, const Vec3& a, Search* search) const {
  FrictionLaws& laws = state_.laws;
  const double rounding = rounding_of_accelerations * state_.system.acceleration_scales()[state_.neighbourhood(c)];
  const double along = dot(a, laws.direction(c)), size = norm(a);
  // Other sticking contacts may hold this one in place. Then it bears its static limit, before it bears less in
  // sliding.
  const bool is_held = along <= rounding;
  if (is_held != laws.is_at_limit(c) && laws.static_coefficient(c) > laws.coefficient_of_sliding(c)) {
    laws.set_at_limit(c, is_held);
    search->has_changed = search->has_reached_limit = true;
  }
  // On a surface the direction of sliding is a part of the solution.
  if (search->is_solved[c] != 0 || state_.tangents[c].num_guides != 1) return;
  if (!(size > rounding && along < (1.0 - 1e-13) * size)) return;
  laws.set_slip_direction(c, (1.0 / size) * a);
  search->has_changed = search->has_changed || along < (1.0 - 1e-12) * size;
}

/// Lets contacts that share a load share it otherwise. Returns true if the shares have changed.
bool ModePivoting::share_otherwise(Search* search) {
  constexpr int most_shares = 20;
  constexpr double enough_to_spare = 0.9;
  const double* const lambda = state_.system.lambda().data();
  double worst_load = -1.0;
  for (std::size_t c = 0; state_.shares_loads && c < state_.size(); ++c) {
    const bool counts = search->may_share[c] != 0 && state_.tangents.sticks(c);
    const double limit = counts ? state_.laws.static_limit(c, lambda) : 0.0;
    search->loads[c] = !counts ? -1.0 : limit > 0.0 ? state_.held(c, lambda) / limit : 1.0;
    if (limit > 0.0) worst_load = std::max(worst_load, search->loads[c]);
  }
  const bool is_asked =
      !search->too_much.empty() || search->num_shares > 0 || (search->pass == 0 && !search->at.releases.empty());
  if (is_asked && worst_load > enough_to_spare && search->num_shares < most_shares &&
      worst_load < 0.99 * search->last_load) {
    ++search->num_shares;
    search->last_load = worst_load;
    state_.share_again(search->loads);
    return true;
  }
  search->last_load = 0.0;
  return false;
}

/// Releases all contacts that are at their limit if no share of the load leaves anything to spare.
void ModePivoting::give_way_together(Search* search) {
  const bool may_give_way = state_.shares_loads && !search->has_given_way && !search->at.releases.empty();
  for (std::size_t c = 0; may_give_way && c < state_.size(); ++c) {
    if (search->loads[c] < 1.0 - 1e-8) continue;
    release(c);
    search->has_changed = true;
  }
  search->has_given_way = true;
}

/// Releases many contacts at once in the first passes, then one by one.
void ModePivoting::release_worst(Search* search) {
  constexpr std::size_t passes_at_once = 10;
  const double share = search->pass < passes_at_once ? 0.5 : 1.0;
  double worst = 0.0;
  for (const auto& [excess, contact] : search->too_much) worst = std::max(worst, excess);
  for (const auto& [excess, contact] : search->too_much) {
    if (search->has_reached_limit || excess < share * worst) continue;
    ++search->released[contact];
    release(contact);
    for (std::size_t other = 0; other < state_.size(); ++other) state_.laws.set_at_limit(other, false);
    search->has_changed = true;
  }
}

/// Also releases contacts whose event was located within rounding below their limit, or that exceed it by rounding.
/// Otherwise their event would be met again at once.
void ModePivoting::release_met(Search* search) {
  const double* const lambda = state_.system.lambda().data();
  for (std::size_t c = 0; !search->has_changed && !search->at.releases.empty() && c < state_.size(); ++c) {
    if (search->may_share[c] == 0 || !state_.tangents.sticks(c) || search->released[c] != 0) continue;
    const double limit =
        (search->at.is_released(c) ? 1.0 - 1e-8 : 1.0 + limit_slack) * state_.laws.static_limit(c, lambda);
    if (!(state_.held(c, lambda) >= limit)) continue;
    ++search->released[c];
    release(c);
    search->has_changed = true;
  }
}

}  // namespace tanor::detail
