#include "dynamics/joints.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/disjoint_sets.hpp"
#include "base/numbers.hpp"
#include "base/vec3.hpp"

namespace tanor::detail {

Joints::Joints(std::span<const Incidence> incidences, std::span<const Coupling> couplings, std::size_t num_moving)
    : group_(num_moving) {
  std::iota(group_.begin(), group_.end(), 0);
  const auto moves = [&](Index point) { return static_cast<std::size_t>(point) < num_moving; };
  const auto join = [&](Index i, Index j) {
    if (moves(i) && moves(j)) join_sets(group_.data(), i, j);
  };
  // In each row, join the first moving point with every other one.
  std::vector<Index> first_of_row;
  for (const Incidence& incidence : incidences) {
    const auto row = static_cast<std::size_t>(incidence.row);
    if (first_of_row.size() <= row) first_of_row.resize(row + 1, -1);
    if (!moves(incidence.point)) continue;
    if (first_of_row[row] < 0) first_of_row[row] = incidence.point;
    join(first_of_row[row], incidence.point);
  }
  for (const Coupling& coupling : couplings) join(coupling.i, coupling.j);
  // The root of a set comes before its other members.
  for (std::size_t i = 0; i < num_moving; ++i) {
    const auto root = static_cast<std::size_t>(group_[i]);
    group_[i] = root == i ? static_cast<Index>(num_groups_++) : group_[root];
  }
  first_.resize(num_groups_);
  for (std::size_t i = num_moving; i-- > 0;) first_[static_cast<std::size_t>(group_[i])] = i;
  for (std::vector<double>* array : {&allowed_x_, &allowed_v_, &speed_, &size_, &atol_})
    array->resize(num_groups_, 0.0);
}

void Joints::largest_differences(const double* a, const double* b, std::span<double> largest) const {
  std::fill(largest.begin(), largest.end(), 0.0);
  for (std::size_t i = 0; i < group_.size(); ++i) {
    double& of_group = largest[group_[i]];
    of_group = std::max(of_group, norm(load(a, i) - load(b, i)));
  }
}

double Joints::allow_rounding(const RoundingLevels& levels, const RoundingGain& gain, const StepTarget& target,
                              const Scales& scales) {
  constexpr double matters = 0.1;  // of the tolerance
  // Skip the points if rounding is small even beside the absolute tolerance.
  bool may_matter = false;
  for (std::size_t k = 0; k < num_groups_ && !may_matter; ++k)
    may_matter = gain.factor * target.h * std::max(levels.whole[k], levels.along[k]) >
                 matters * scales.velocity_tolerance(target.atol, first_[k]);
  allows_rounding_ = false;
  if (!may_matter) return 0.0;
  std::fill(speed_.begin(), speed_.end(), 0.0);
  std::fill(size_.begin(), size_.end(), 0.0);
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const auto k = static_cast<std::size_t>(group_[i]);
    speed_[k] = std::max(speed_[k], norm(load(target.v, i)));
    size_[k] = std::max(size_[k], norm(load(target.x, i)));
    atol_[k] = scales.velocity_tolerance(target.atol, i);
  }
  double worst = 0.0;
  for (std::size_t k = 0; k < num_groups_; ++k) {
    const double tolerance = atol_[k] + target.rtol * speed_[k], level = levels.along[k];
    allows_rounding_ = allows_rounding_ || gain.factor * target.h * levels.whole[k] > matters * tolerance;
    // A change of x by eps |x| changes accelerations by the level, so their ratio is the square of a frequency.
    const double answer = std::sqrt(eps * size_[k] / level);
    const double time = gain.is_damped && answer < target.h ? answer : target.h;
    allowed_v_[k] = gain.factor * time * level;
    allowed_x_[k] = time * allowed_v_[k];
    worst = std::max(worst, allowed_v_[k] / tolerance);
  }
  return worst;
}

ErrorRatios Joints::error_ratios(const StepErrors& errors, double atol, double rtol, const Scales& scales) const {
  ErrorRatios worst{0.0, 0.0};
  const auto ratio = [&](const double* error, const double* from, const double* to, std::size_t i, double allowed) {
    const Vec3 a = load(from, i), b = load(to, i);
    const double square =
        std::max(a.x * a.x, b.x * b.x) + std::max(a.y * a.y, b.y * b.y) + std::max(a.z * a.z, b.z * b.z);
    return norm(load(error, i)) / (rtol * std::sqrt(square) + allowed);
  };
  for (std::size_t i = 0; i < group_.size(); ++i) {
    const auto k = static_cast<std::size_t>(group_[i]);
    worst.x = larger(
        worst.x, ratio(errors.x, errors.x_from, errors.x_to, i, scales.position_tolerance(atol, i) + allowed_x_[k]));
    worst.v = larger(
        worst.v, ratio(errors.v, errors.v_from, errors.v_to, i, scales.velocity_tolerance(atol, i) + allowed_v_[k]));
  }
  return worst;
}

}  // namespace tanor::detail
