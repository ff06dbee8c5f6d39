#include <algorithm>
#include <cmath>

#include "dynamics/friction_stage.hpp"

/// \file Contacts at rest, all together, as a problem without modes.
namespace tanor {

/// With limits that stand, |tau_c| <= L_c, the friction at rest is the least of a convex function (Tresca's problem),
///
///   1/2 tau'W tau + a0'tau,   a = W tau + a0 the accelerations T'w of the contacts,   W: S without its other rows
///
/// found by alternating directions (Boyd et al., Found. Trends Mach. Learn. 3, 2011) with rho = compliance/m, one solve
/// each; L_c = mu |N_c| follows the multipliers:
///
///   lambda = -(S + rho)^-1 (b - rho (z - u)),   z = lambda_t + u cut off at L,   u += lambda_t - z
///
/// At the end a = -rho u: what sticks has u = 0, what slides goes against its force. Nothing divides by what W lacks in
/// rank. What it leaves is polished by the modes that it says.
void FrictionStage::relax(const double* b, double compliance, std::vector<RestingContact>* resting, double* lambda) {
  constexpr int most_iterations = 3000;
  constexpr double tolerance = 1e-12;
  constexpr double over_relaxation = 1.6;
  std::vector<double> shifted(b, b + right_side_.size());
  laws_.evaluate(model_.parallel, lambda, x_.data());
  int iteration = 0;
  double change = 1.0, size = 0.0;
  for (; iteration < most_iterations && change > tolerance * size; ++iteration) {
    for (const RestingContact& each : *resting) {
      const Tangents::Place& place = tangents_[each.contact];
      const double rho = compliance * model_.inverse_mass[static_cast<std::size_t>(place.point)];
      for (int k = 0; k < place.num_tangents(); ++k) {
        const Vec3 direction = tangents_.directions(each.contact)[static_cast<std::size_t>(k)];
        shifted[static_cast<std::size_t>(place.first_row + k)] =
            b[place.first_row + k] - rho * dot(direction, each.force - each.excess);
      }
    }
    set_right_side(shifted.data());
    find_multipliers(x_.data(), lambda);
    laws_.evaluate(model_.parallel, lambda, x_.data());
    change = size = 0.0;
    for (RestingContact& each : *resting) {
      const Vec3 now = held(each.contact, lambda);
      const Vec3 wanted = over_relaxation * now + (1.0 - over_relaxation) * each.force + each.excess;
      each.limit = each.coefficient * norm(laws_.normal_force(each.contact, lambda));
      const double length = norm(wanted);
      const Vec3 force = length > each.limit ? (each.limit / length) * wanted : wanted;
      change = std::max({change, norm(now - force), norm(force - each.force)});
      size = std::max({size, each.limit, norm(now)});
      each.force = force;
      each.excess = wanted - force;
    }
  }
  model_.counters.solves += static_cast<std::size_t>(iteration);
}

}  // namespace tanor
