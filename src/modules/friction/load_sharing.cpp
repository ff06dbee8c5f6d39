#include "friction/load_sharing.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tanor::detail {

void LoadSharing::forget() {
  state_.shares_loads = false;
  system_.gram().set_compliance(0.0);
}

bool LoadSharing::begin() {
  if (state_.shares_loads || state_.tangents.num_sticking() == 0) return false;
  state_.shares_loads = true;
  const Numbering& numbering = state_.model.numbering;
  std::vector<double> weights(state_.model.num_rows() - numbering.num_user_rows, 1.0);
  for (std::size_t c = 0; c < state_.size() && !state_.softness.empty(); ++c) {
    const Tangents::Place& place = state_.tangents[c];
    for (int k = 0; place.first_row >= 0 && k < place.num_tangents(); ++k) {
      const auto row = static_cast<std::size_t>(numbering.user_row[static_cast<std::size_t>(place.first_row + k)]);
      weights[row - numbering.num_user_rows] =
          std::exp2(-static_cast<double>(state_.softness[c]) / ContactState::softness_steps);
    }
  }
  system_.gram().set_compliance(compliance, std::move(weights));
  return true;
}

bool LoadSharing::has_references() const {
  for (std::size_t c = 0; state_.num_switches > 0 && c < state_.size(); ++c) {
    if (state_.tangents.sticks(c) && norm(state_.laws.reference(c)) > 0.0) return true;
  }
  return false;
}

void LoadSharing::share_again(const std::vector<double>& loads) {
  constexpr double least_load = 0.05;
  constexpr int steps = ContactState::softness_steps, hardest = 12 * steps;
  std::vector<int>& softness = state_.softness;
  softness.resize(loads.size(), 0);
  int softest = hardest;
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] < 0.0) continue;
    const double load = std::max(least_load, std::min(loads[c], 1.0 / least_load));
    softness[c] -= static_cast<int>(std::lround(2.0 * steps * std::log2(load)));
    softest = std::min(softest, softness[c]);
  }
  for (std::size_t c = 0; c < loads.size(); ++c) {
    if (loads[c] >= 0.0) softness[c] = std::clamp(softness[c] - softest, 0, hardest);
    if (!state_.tangents.sticks(c)) softness[c] = 0;
  }
  forget();
}

}  // namespace tanor::detail
