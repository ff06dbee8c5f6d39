#pragma once

#include <algorithm>
#include <cmath>

#include "base/point_path.hpp"
#include "base/root_bracket.hpp"

namespace tanor::detail {

/// Returns where f falls through 0 between low and high, on the far side. Requires f(low) > 0 >= f(high).
template <class Function>
double find_fall(double low, double high, const Function& f) {
  constexpr double narrow = 1e-16;
  RootBracket bracket(low, f(low), high, f(high), narrow * std::max(1.0, std::abs(high)));
  (void)bracket.narrow_by(f);
  return bracket.high();
}

/// Locates a jump of a force to rounding. `side(path, s)` is positive on the side where the step begins and falls
/// through 0 between `low` and `high`, or at both if they are the same; what is nearer to 0 than `margin` is uncertain.
/// The path is magnified there until its cubics are exact: what is found in a longer part is the middle of a shorter
/// one. Where the other side is only touched within the margin, there is no jump.
template <class Side>
PointPath::Jump locate_jump(PointPath* path, double low, double high, double margin, const Side& side) {
  constexpr double least_reach = 1e-4, most_reach = 0.1;
  constexpr int most_times = 3;
  double near = low < high ? find_fall(low, high, [&](double s) { return side(*path, s); }) : high;
  int times = 0;
  for (double reach = least_reach; reach <= most_reach; reach *= 10.0) {
    const double begin = std::max(0.0, near - reach), end = std::min(1.0, near + reach);
    const PointPath* const part = path->magnify(begin, end);
    if (part == nullptr) break;
    const auto before = [&](double s) { return side(*part, s) - margin; };
    const auto after = [&](double s) { return side(*part, s) + margin; };
    const bool begins_before = before(0.0) > 0.0, ends_after = after(1.0) <= 0.0;
    if ((!begins_before && begin > 0.0) || (!ends_after && end < 1.0)) continue;
    if (!begins_before && !ends_after) break;
    const double last = !ends_after ? 1.0 : after(0.0) > 0.0 ? find_fall(0.0, 1.0, after) : 0.0;
    const double first = begins_before && before(last) <= 0.0 ? find_fall(0.0, last, before) : 0.0;
    const PointPath::Jump found{begin + first * (end - begin), begin + last * (end - begin)};
    if (reach == least_reach || ++times == most_times) return found;
    near = found.after;
    reach = 0.1 * least_reach;  // begins again with the least
  }
  return {};
}

}  // namespace tanor::detail
