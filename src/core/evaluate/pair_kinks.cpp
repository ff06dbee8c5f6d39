#include <algorithm>
#include <cmath>

#include "base/gauss_rule.hpp"
#include "evaluate/locate_jump.hpp"
#include "evaluate/pair_field.hpp"

/// \file Contacts of pairs that begin or end inside a step.
namespace tanor::detail {

Vec3 PairField::force_along(const PointPath& path, const Approach& approach, double s) const {
  const Vec3 d = relative(path, approach, s).r;
  const double r = norm(d);
  return r < potential_.cutoff() ? (potential_.signed_force_at(r) / r) * d : Vec3{};
}

/// Examines a contact that begins or ends inside the step, or of which the step goes through a large part. The pair's
/// impulse on the path is compared with the scheme's quadrature over its looks,
///
///   h (integral F(s) ds - sum_i w_i F(s_i))
///
/// If they differ, the next attempt ends at the kink, with a smooth force on either side.
double PairField::resolve_kinks(const PointPath& path, const Approach& approach, const Encounter& nearest,
                                std::span<const double> masses) const {
  constexpr double allowed_kink = 25.0;  // tolerances that the kink of one pair may cost in a step
  if (!path.follows_tolerance || !neighbours_ || !(nearest.r < potential_.cutoff())) return 1.0;
  const double cutoff2 = potential_.cutoff() * potential_.cutoff();
  const auto beyond = [&](double s) { return squared(relative(path, approach, s).r) - cutoff2; };
  const bool begins = beyond(0.0) > 0.0, ends = beyond(1.0) > 0.0;
  const double farthest2 = std::max(beyond(0.0), beyond(1.0)) + cutoff2;
  if (!begins && !ends && farthest2 <= far_apart2 * nearest.r * nearest.r) return 1.0;
  const double a = begins ? find_fall(0.0, nearest.s, beyond) : 0.0;
  const double b = ends ? find_fall(nearest.s, 1.0, [&](double s) { return -beyond(s); }) : 1.0;
  Vec3 missed{};
  for (const auto& [s, weight] : gauss_rule)
    missed = missed + ((b - a) * weight) * force_along(path, approach, a + s * (b - a));
  for (std::size_t k = 0; k < path.looks.size(); ++k)
    missed = missed - path.weights[k] * force_along(path, approach, path.looks[k]);
  const double error = measure(path, approach, norm(missed) * path.h, masses) / allowed_kink;
  if (!(error > 1.0)) return 1.0;
  constexpr double least = 0.02, most = 0.98;
  for (const double kink : {a, b}) {
    if (kink > least && kink < most) return kink;
  }
  return std::clamp(0.9 / std::sqrt(error), 0.1, 0.9);
}

}  // namespace tanor::detail
