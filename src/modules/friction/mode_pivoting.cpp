#include <algorithm>
#include <limits>
#include <utility>

#include "base/text.hpp"
#include "friction/contact_choices.hpp"

namespace tanor::detail {

namespace {

/// The state of one search by block pivoting. Sticking contacts above their limit are released against the friction
/// that held them. Released contacts that do not slide off are held again. This repeats until all obey the law, with
/// many contacts at once in the first passes, then one by one.
class Pivoting {
 public:
  Pivoting(ContactState& state, const ModeSwitch& at, const std::vector<ContactChoice>& choices,
           const ContactIslands& islands);
  Outcome run(std::span<const char> are_counted);

 private:
  Outcome look();
  void look_at_sliding(std::size_t contact, const Vec3& a);
  bool share_otherwise();
  void give_way_together();
  void release_worst();
  void release_met();
  void release(std::size_t contact) {
    state_.release(contact, state_.system.lambda().data());
    has_changed_ = true;
  }

  ContactState& state_;
  const ModeSwitch& at_;
  std::vector<char> is_open_;    // [contact] at rest, and without a share that is known
  std::vector<char> may_share_;  // [contact] the same, of islands that have changed
  std::vector<char> is_solved_;  // [contact] its slip direction was solved for, so small accelerations keep it
  std::vector<int> released_;    // [contact] how often
  std::vector<double> loads_;    // [contact] held over limit if it sticks; otherwise negative
  double last_load_ = std::numeric_limits<double>::infinity();  // the largest one at the last change of shares
  std::size_t pass_ = 0;
  int num_shares_ = 0;
  bool has_given_way_ = false;
  // The members below belong to the present pass.
  bool has_changed_ = false, has_reached_limit_ = false;
  std::vector<std::pair<double, std::size_t>> too_much_;  // relative excess over the limit; contact
};

Pivoting::Pivoting(ContactState& state, const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                   const ContactIslands& islands)
    : state_(state),
      at_(at),
      is_open_(at.at_rest),
      may_share_(state.size(), 0),
      is_solved_(state.size(), 0),
      released_(state.size(), 0),
      loads_(state.size(), -1.0) {
  std::vector<char> is_known(state.size(), 0);
  for (const ContactChoice& choice : choices) {
    for (const std::size_t c : choice.members) {
      is_solved_[c] = choice.has_solution();
      is_known[c] = choice.has_shared;
    }
  }
  for (std::size_t c = 0; c < state.size(); ++c) {
    const bool may_change = at.has_changed[islands.of_contact[c]] != 0 && is_known[c] == 0;
    if (is_known[c] != 0) is_open_[c] = 0;
    may_share_[c] = may_change && at.at_rest[c] != 0;
    // The other contacts share their load anew.
    if (may_change) state.laws.set_reference(c, {});
  }
}

Outcome Pivoting::run(std::span<const char> are_counted) {
  constexpr std::size_t most_passes = 40;
  Request on_the_way = at_.request;
  on_the_way.gradients = Gradients::Evaluate;
  on_the_way.verification = Verification::None;
  const AccelerationOutput to{at_.to.a, nullptr, at_.to.report};
  const std::size_t num_at_rest = at_.num_at_rest();
  for (; pass_ < most_passes; ++pass_) {
    Outcome outcome = state_.system.accelerations({at_.t, at_.r, at_.v}, on_the_way, are_counted, to);
    if (!outcome.ok() || num_at_rest == 0) return outcome;
    if (outcome = look(); !outcome.ok()) return outcome;
    if (share_otherwise()) continue;
    give_way_together();
    release_worst();
    release_met();
    if (!has_changed_) return {};
    std::fill(is_solved_.begin(), is_solved_.end(), 0);
  }
  return fail_friction(Status::NotConverged, at_.t,
                       "no choice of which contacts stick and which slide obeys the law for all of " +
                           text(static_cast<double>(num_at_rest)) + " at rest");
}

/// Finds, at the last accelerations, the sticking contacts that hold too much and the sliding contacts that move
/// backwards. The latter stick again.
Outcome Pivoting::look() {
  constexpr int most_releases = 4;
  Workspace& work = state_.work;
  const Model& model = state_.model;
  Tangents& tangents = state_.tangents;
  const double* const lambda = state_.system.lambda().data();
  std::vector<double> rows(model.num_rows());  // T'w + phi
  work.constraints.evaluate_contacts(model.parallel, at_.r, at_.v, at_.to.a, Tangents::Which::All, rows.data());
  has_changed_ = has_reached_limit_ = false;
  too_much_.clear();
  for (std::size_t c = 0; c < state_.size(); ++c) {
    if (is_open_[c] == 0) continue;
    const double scale = state_.system.acceleration_scales()[state_.neighbourhood(c)];
    if (tangents.sticks(c)) {
      const double limit = state_.limit(c, lambda), held = state_.held(c, lambda);
      const double rounding = 1e-13 * scale * state_.mass(c);
      if (held - (1.0 + limit_slack) * limit > rounding) too_much_.emplace_back((held - limit) / held, c);
      continue;
    }
    const Vec3 a = state_.laws.along_tangents(c, rows.data());
    // A sliding contact must accelerate along its slip direction.
    if (!(dot(a, state_.laws.direction(c)) < -rounding_of_accelerations * scale)) {
      look_at_sliding(c, a);
      continue;
    }
    if (released_[c] >= most_releases) {
      return fail_friction(Status::NoSolution, at_.t,
                           work.name_contact(c) + " can neither stick nor slide; the velocity would have to jump");
    }
    tangents.set_stick(c, true);
    has_changed_ = true;
  }
  return {};
}

/// Updates the limit and the slip direction of a contact that begins to slide with the acceleration a.
void Pivoting::look_at_sliding(std::size_t c, const Vec3& a) {
  FrictionLaws& laws = state_.laws;
  const double rounding = rounding_of_accelerations * state_.system.acceleration_scales()[state_.neighbourhood(c)];
  const double along = dot(a, laws.direction(c)), size = norm(a);
  // Other sticking contacts may hold this one in place. Then it bears its static limit, before it bears less in
  // sliding.
  const bool is_held = along <= rounding;
  if (is_held != laws.is_at_limit(c) && laws.static_coefficient(c) > laws.coefficient_of_sliding(c)) {
    laws.set_at_limit(c, is_held);
    has_changed_ = has_reached_limit_ = true;
  }
  // On a surface the direction of sliding is a part of the solution.
  if (is_solved_[c] != 0 || state_.tangents[c].num_guides != 1) return;
  if (!(size > rounding && along < (1.0 - 1e-13) * size)) return;
  laws.set_slip_direction(c, (1.0 / size) * a);
  has_changed_ = has_changed_ || along < (1.0 - 1e-12) * size;
}

/// Lets contacts that share a load share it otherwise. Returns true if the shares have changed.
bool Pivoting::share_otherwise() {
  constexpr int most_shares = 20;
  constexpr double enough_to_spare = 0.9;
  const double* const lambda = state_.system.lambda().data();
  double worst_load = -1.0;
  for (std::size_t c = 0; state_.shares_loads && c < state_.size(); ++c) {
    const bool counts = may_share_[c] != 0 && state_.tangents.sticks(c);
    const double limit = counts ? state_.laws.static_limit(c, lambda) : 0.0;
    loads_[c] = !counts ? -1.0 : limit > 0.0 ? state_.held(c, lambda) / limit : 1.0;
    if (limit > 0.0) worst_load = std::max(worst_load, loads_[c]);
  }
  const bool is_asked = !too_much_.empty() || num_shares_ > 0 || (pass_ == 0 && !at_.releases.empty());
  if (is_asked && worst_load > enough_to_spare && num_shares_ < most_shares && worst_load < 0.99 * last_load_) {
    ++num_shares_;
    last_load_ = worst_load;
    state_.share_again(loads_);
    return true;
  }
  last_load_ = 0.0;
  return false;
}

/// Releases all contacts that are at their limit if no share of the load leaves anything to spare.
void Pivoting::give_way_together() {
  const bool may_give_way = state_.shares_loads && !has_given_way_ && !at_.releases.empty();
  for (std::size_t c = 0; may_give_way && c < state_.size(); ++c) {
    if (loads_[c] >= 1.0 - 1e-8) release(c);
  }
  has_given_way_ = true;
}

/// Releases many contacts at once in the first passes, then one by one.
void Pivoting::release_worst() {
  constexpr std::size_t passes_at_once = 10;
  const double share = pass_ < passes_at_once ? 0.5 : 1.0;
  double worst = 0.0;
  for (const auto& [excess, contact] : too_much_) worst = std::max(worst, excess);
  for (const auto& [excess, contact] : too_much_) {
    if (has_reached_limit_ || excess < share * worst) continue;
    ++released_[contact];
    release(contact);
    for (std::size_t other = 0; other < state_.size(); ++other) state_.laws.set_at_limit(other, false);
  }
}

/// Also releases contacts whose event was located within rounding below their limit, or that exceed it by rounding.
/// Otherwise their event would be met again at once.
void Pivoting::release_met() {
  const double* const lambda = state_.system.lambda().data();
  for (std::size_t c = 0; !has_changed_ && !at_.releases.empty() && c < state_.size(); ++c) {
    if (may_share_[c] == 0 || !state_.tangents.sticks(c) || released_[c] != 0) continue;
    const double limit = (at_.is_released(c) ? 1.0 - 1e-8 : 1.0 + limit_slack) * state_.laws.static_limit(c, lambda);
    if (!(state_.held(c, lambda) >= limit)) continue;
    ++released_[c];
    release(c);
  }
}

}  // namespace

Outcome find_complementary_modes(ContactState& state, const ModeSwitch& at, const std::vector<ContactChoice>& choices,
                                 const ContactIslands& islands, std::span<const char> are_counted) {
  return Pivoting(state, at, choices, islands).run(are_counted);
}

}  // namespace tanor::detail
