#include "dynamics/contact_state.hpp"

#include <algorithm>
#include <string>

namespace tanor {

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

ContactState::ContactState(Workspace& a_work, FrictionLaws& a_laws)
    : work(a_work), model(a_work.model()), tangents(a_work.constraints.tangents()), laws(a_laws), places(a_work) {
  for (std::size_t c = 0; c < size(); ++c) num_switches += may_stick(c) ? 1 : 0;
}

double ContactState::sliding_threshold(std::size_t contact) const {
  return 1e-11 * work.scales.speed(neighbourhood(contact));
}

void ContactState::set_sliding_speeds() {
  constexpr double slow = 3e-7;
  for (std::size_t c = 0; c < size(); ++c)
    laws.set_speeds(c, sliding_threshold(c), slow * work.scales.speed(neighbourhood(c)));
}

double ContactState::limit(std::size_t contact, const double* lambda) const {
  const double factor = !overloads.empty() && overloads[contact] != 0 ? 1.0 + overload : 1.0;
  return factor * static_limit(laws, contact, lambda);
}

void ContactState::release(std::size_t contact, const double* lambda) {
  const Vec3 held = held_friction(tangents, laws, contact, lambda);
  const double size = norm(held);
  laws.set_sense(contact, size > 0.0 ? (-1.0 / size) * held : tangents.directions(contact)[0]);
  tangents.set_stick(contact, false);
}

void ContactState::let_slide(std::size_t contact) {
  tangents.set_stick(contact, false);
  laws.set_sense(contact, {});
}

/// On a curve the sense of sliding is kept too, as its sign along T: at rest the velocity does not tell it. How a load
/// is shared stands in multiples of the number of modes.
std::vector<int> ContactState::discrete_state() const {
  std::vector<int> state;
  for (std::size_t c = 0; num_switches > 0 && c < size(); ++c) {
    const double along = dot(laws.sense(c), tangents.directions(c)[0]);
    state.push_back(tangents.sticks(c)                            ? sticks
                    : tangents[c].num_guides == 1 || along == 0.0 ? slides
                    : along > 0.0                                 ? slides_forward
                                                                  : slides_backward);
    if (state.back() > sticks && laws.is_at_limit(c)) state.back() += at_limit;
    if (!overloads.empty() && overloads[c] != 0) state.back() = overloaded;
    if (!softness.empty()) state.back() += num_modes * softness[c];
  }
  return state;
}

void ContactState::restore_discrete_state(std::span<const int> state) {
  const std::size_t wanted = num_switches > 0 ? size() : 0;
  if (state.size() != wanted) {
    throw InputError("/snapshot/discrete_state", std::to_string(state.size()) + " modes for " + std::to_string(wanted) +
                                                     " contacts that may stick");
  }
  restored_.assign(state.begin(), state.end());
  softness.assign(state.size(), 0);
  overloads.assign(state.size(), 0);
  for (std::size_t c = 0; c < state.size(); ++c) {
    softness[c] = std::max(0, state[c] / num_modes);
    restored_[c] -= num_modes * softness[c];
    if (restored_[c] == overloaded) {
      overloads[c] = 1;
      restored_[c] = sticks;
    }
    tangents.set_stick(c, restored_[c] == sticks);
  }
}

void ContactState::restore_senses(const double* r, const double* v) {
  if (restored_.empty()) return;
  places.hold(work.time(), r);
  set_sliding_speeds();
  for (std::size_t c = 0; c < restored_.size(); ++c) {
    const Vec3 t = tangents.directions(c)[0];
    const bool is_at_limit = restored_[c] > slides_backward;
    const int mode = is_at_limit ? restored_[c] - at_limit : restored_[c];
    laws.set_sense(c, mode == slides_forward ? t : mode == slides_backward ? -t : Vec3{});
    laws.set_at_limit(c, is_at_limit);
  }
  laws.keep_senses(v);
  restored_.clear();
}

}  // namespace tanor
