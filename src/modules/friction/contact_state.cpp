#include "friction/contact_state.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

namespace {

enum Mode : int {
  slides = 0,
  sticks = 1,
  slides_forward = 2,
  slides_backward = 3,
  at_limit = 2,
  overloaded = 6,
  num_modes = 7
};  // 4 and 5 are the two senses of sliding at the limit

/// Rounding grows by the inverse of the compliance of rows that share a load; refinement reduces errors by this factor.
constexpr double compliance = 1e-4;

}  // namespace

ContactState::ContactState(Workspace& a_work, ConstrainedSystem& a_system)
    : work(a_work),
      system(a_system),
      model(a_work.model()),
      tangents(a_work.constraints.tangents()),
      laws(model.system, model.numbering, tangents, model.incidences),
      places(a_work),
      softness(size(), 0),
      overloads(size(), 0) {
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
  const double factor = overloads[contact] != 0 ? 1.0 + overload : 1.0;
  return factor * laws.static_limit(contact, lambda);
}

void ContactState::release(std::size_t contact, const double* lambda) {
  const Vec3 held = laws.held(contact, lambda);
  const double size = norm(held);
  laws.set_slip_direction(contact, size > 0.0 ? (-1.0 / size) * held : tangents.directions(contact)[0]);
  tangents.set_stick(contact, false);
}

void ContactState::let_slide(std::size_t contact) {
  tangents.set_stick(contact, false);
  laws.set_slip_direction(contact, {});
}

void ContactState::forget(std::size_t contact) {
  laws.set_slip_direction(contact, {});
  laws.set_at_limit(contact, false);
  laws.set_reference(contact, {});
  softness[contact] = 0;
  overloads[contact] = 0;
}

/// On a curve the sense of sliding is kept as well, as its sign along T, because the velocity at rest does not tell it.
/// The softness is added in multiples of the number of modes.
std::vector<int> ContactState::discrete_state() const {
  std::vector<int> state;
  for (std::size_t c = 0; num_switches > 0 && c < size(); ++c) {
    const double along = dot(laws.slip_direction(c), tangents.directions(c)[0]);
    state.push_back(tangents.sticks(c)                            ? sticks
                    : tangents[c].num_guides == 1 || along == 0.0 ? slides
                    : along > 0.0                                 ? slides_forward
                                                                  : slides_backward);
    if (state.back() > sticks && laws.is_at_limit(c)) state.back() += at_limit;
    if (overloads[c] != 0) state.back() = overloaded;
    state.back() += num_modes * softness[c];
  }
  return state;
}

std::string ContactState::describe_change(std::span<const int> before) const {
  const std::vector<int> now = discrete_state();
  std::string change;
  for (std::size_t c = 0; c < std::min(now.size(), before.size()); ++c) {
    if (now[c] % num_modes == before[c] % num_modes) continue;
    if (!change.empty()) return change + ", and others";
    change = work.name_contact(c) + (tangents.sticks(c) ? " sticks" : " slips");
  }
  return change;
}

void ContactState::restore_discrete_state(std::span<const int> state) {
  const std::size_t wanted = num_switches > 0 ? size() : 0;
  if (state.size() != wanted) {
    throw InputError("/snapshot/discrete_state", std::to_string(state.size()) + " modes for " + std::to_string(wanted) +
                                                     " contacts that may stick");
  }
  restored_.assign(state.begin(), state.end());
  softness.assign(size(), 0);
  overloads.assign(size(), 0);
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

void ContactState::restore_slip_directions(const double* r, const double* v) {
  if (restored_.empty()) return;
  places.hold(work.time(), r);
  set_sliding_speeds();
  for (std::size_t c = 0; c < restored_.size(); ++c) {
    const Vec3 t = tangents.directions(c)[0];
    const bool is_at_limit = restored_[c] > slides_backward;
    const int mode = is_at_limit ? restored_[c] - at_limit : restored_[c];
    laws.set_slip_direction(c, mode == slides_forward ? t : mode == slides_backward ? -t : Vec3{});
    laws.set_at_limit(c, is_at_limit);
  }
  laws.keep_slip_directions(v);
  restored_.clear();
}

// ---- shares of a load ----

void ContactState::forget_shares() {
  shares_loads = false;
  system.gram().set_compliance(0.0);
}

bool ContactState::begin_sharing() {
  if (shares_loads || tangents.num_sticking() == 0) return false;
  shares_loads = true;
  const Numbering& numbering = model.numbering;
  std::vector<double> weights(model.num_rows() - numbering.num_user_rows, 1.0);
  for (std::size_t c = 0; c < size(); ++c) {
    const Tangents::Place& place = tangents[c];
    for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k) {
      const auto row = static_cast<std::size_t>(numbering.user_row[static_cast<std::size_t>(place.first_row + k)]);
      weights[row - numbering.num_user_rows] = std::exp2(-static_cast<double>(softness[c]) / softness_steps);
    }
  }
  system.gram().set_compliance(compliance, std::move(weights));
  return true;
}

bool ContactState::has_references() const {
  for (std::size_t c = 0; num_switches > 0 && c < size(); ++c) {
    if (tangents.sticks(c) && norm(laws.reference(c)) > 0.0) return true;
  }
  return false;
}

void ContactState::share_again(const std::vector<double>& loads) {
  constexpr double least_load = 0.05;
  constexpr int steps = softness_steps, hardest = 12 * steps;
  int softest = hardest;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] < 0.0) continue;
    const double load = std::max(least_load, std::min(loads[c], 1.0 / least_load));
    softness[c] -= static_cast<int>(std::lround(2.0 * steps * std::log2(load)));
    softest = std::min(softest, softness[c]);
  }
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] >= 0.0) softness[c] = std::clamp(softness[c] - softest, 0, hardest);
    if (!tangents.sticks(c)) softness[c] = 0;
  }
  forget_shares();
}

// ---- verdicts ----

void ContactState::add_verdict(FrictionReport* report) const {
  const auto add = [&](Uniqueness uniqueness, const std::string& reason) {
    if (uniqueness < report->uniqueness || (uniqueness == report->uniqueness && !report->uniqueness_reason.empty()))
      return;
    report->uniqueness = uniqueness;
    report->uniqueness_reason = reason;
  };
  if (const std::string contact = find_undetermined_reaction(); !contact.empty()) {
    add(Uniqueness::Unproven, "constraints that depend on each other share the reaction of " + contact +
                                  " by convention, and the motion depends on the share");
  }
  if (verdict.uniqueness > Uniqueness::Proven) add(verdict.uniqueness, verdict.reason);
  // An answer that is not proven has no error bound.
  if (report->uniqueness != Uniqueness::Proven) report->error_bound = std::numeric_limits<double>::quiet_NaN();
}

std::string ContactState::find_undetermined_reaction() const {
  const Dependences& redundancy = system.redundancy();
  if (!redundancy.is_found()) return {};
  std::vector<double> lengths(model.num_rows(), 0.0);  // of the gradients in the norm of M^-1
  for (const Incidence& i : model.incidences) {
    const Vec3 g = load(system.blocks().data(), i.block);
    lengths[static_cast<std::size_t>(i.row)] += model.inverse_mass[static_cast<std::size_t>(i.point)] * dot(g, g);
  }
  for (double& length : lengths) length = length > 0.0 ? std::sqrt(length) : 1.0;
  std::vector<double> z(model.num_rows(), 0.0);  // K z = 0
  for (const Dependence& found : redundancy.list()) {
    std::fill(z.begin(), z.end(), 0.0);
    const auto row = static_cast<std::size_t>(found.column);
    z[row] = 1.0 / lengths[row];
    double largest = z[row];
    for (const auto& [other, coefficient] : found.terms) {
      const auto a = static_cast<std::size_t>(other);
      z[a] = -coefficient / lengths[a];
      largest = std::max(largest, std::abs(z[a]));
    }
    for (std::size_t c = 0; c < size(); ++c) {
      constexpr double rounding = 1e-8;
      if (!laws.is_coulomb(c) || laws.static_coefficient(c) == 0.0) continue;
      if (norm(laws.normal_force(c, z.data(), system.blocks().data())) > rounding * largest)
        return work.name_contact(c);
    }
  }
  return {};
}

}  // namespace tanor::detail
