#include "friction/friction_scales.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tanor::detail {

double largest_of(const std::vector<double>& x) {
  double worst = 0.0;
  for (const double each : x) worst = larger(worst, std::abs(each));
  return worst;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double worst = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) worst = larger(worst, std::abs(a[k] - b[k]));
  return worst;
}

FrictionScales::FrictionScales(const Workspace& work, const FrictionLaws& laws)
    : work_(work), model_(work.model()), laws_(laws) {
  const Tangents& tangents = work.constraints.tangents();
  std::vector<Index> group_of(work.scales.size(), -1);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const std::size_t own = work.scales.of_point(static_cast<std::size_t>(tangents[c].point));
    if (group_of[own] < 0) {
      group_of[own] = static_cast<Index>(neighbourhoods_.size());
      neighbourhoods_.push_back(own);
    }
    group_of_part_.insert(group_of_part_.end(), laws.end_part(c) - laws.first_part(c), group_of[own]);
  }
  least_.assign(neighbourhoods_.size(), 0.0);
}

void FrictionScales::set_accelerations(const std::vector<double>& accelerations) {
  // The rounding of forces is eps m a, so forces below 1e-4 m a have fewer digits than the tolerance of the iterations.
  constexpr double part = 1e-4;
  const Tangents& tangents = work_.constraints.tangents();
  std::fill(least_.begin(), least_.end(), 0.0);
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const auto group = static_cast<std::size_t>(group_of_part_[laws_.first_part(c)]);
    const double mass = model_.mass[static_cast<std::size_t>(tangents[c].point)];
    least_[group] = std::max(least_[group], part * mass * accelerations[neighbourhoods_[group]]);
  }
}

double FrictionScales::relative_change(const std::vector<double>& x, const std::vector<double>& before) {
  constexpr double smallest_number = std::numeric_limits<double>::min();
  if (!are_several()) return largest_difference(x, before) / std::max(largest_of(x), smallest_number);
  largest_ = least_;
  largest_change_.assign(least_.size(), 0.0);
  for (std::size_t p = 0; p < x.size(); ++p) {
    const auto group = static_cast<std::size_t>(group_of_part_[p]);
    largest_[group] = larger(largest_[group], std::abs(x[p]));
    largest_change_[group] = larger(largest_change_[group], std::abs(x[p] - before[p]));
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < largest_.size(); ++k)
    worst = larger(worst, largest_change_[k] / std::max(largest_[k], smallest_number));
  return worst;
}

}  // namespace tanor::detail
