#include <algorithm>
#include <array>
#include <cmath>

#include "certificate/verifier.hpp"
#include "dynamics/friction_blocks.hpp"
#include "system/contacts.hpp"
#include "system/friction_magnitude.hpp"

/// \file Verifies friction: the laws once more, straight from the System, at the answer's own multipliers; that
/// sticking contacts stay at rest; (43) by its three blocks.
namespace tanor::detail {

namespace {

/// Returns the magnitude by the law's own file. For such a law the certificate verifies its direction, its arguments,
/// and that (43) was solved.
template <class Law>
double magnitude_again(const Law& law, double speed, double normal) {
  return magnitude_of(law, speed, normal);
}
// These laws are written once more as docs/scene-format.md states them, so that an error in their files shows here.
double magnitude_again(const Coulomb& law, double speed, double normal) {
  const double v0 = law.regularisation.value_or(0.0);
  return law.coefficient * normal * (v0 > 0.0 ? speed / std::sqrt(speed * speed + v0 * v0) : 1.0);
}
double magnitude_again(const Viscous& law, double speed, double) {
  return law.coefficient * speed;
}

}  // namespace

/// One contact at the answer, with P = I - K_g Gamma_g^-1 K_g' onto the directions that its guides leave free.
struct Verifier::Sliding {
  const Tangents::Place& place;
  const Friction& friction;
  bool sticks;
  std::array<Vec3, 2> k{};         ///< K_g
  std::array<double, 2> across{};  ///< c = Gamma_g^-1 K_g'(v - u), how the guide moves across itself
  Vec3 velocity{};                 ///< P (v - u)
  Vec3 acceleration{};             ///< its rate P (w - u_dot - K_g_dot c) at rest
  Vec3 normal{};                   ///< N
  std::array<double, 2> own{};     ///< lambda of the guides

  /// Returns Gamma_g^-1 K_g'a.
  std::array<double, 2> coefficients(Vec3 a) const {
    const double kk = dot(k[0], k[0]), b = dot(k[0], a);
    if (place.num_guides == 1) return {b / kk, 0.0};
    const double kl = dot(k[0], k[1]), ll = dot(k[1], k[1]), d = dot(k[1], a), determinant = kk * ll - kl * kl;
    return {(ll * b - kl * d) / determinant, (kk * d - kl * b) / determinant};
  }
  Vec3 along(Vec3 a) const {
    const auto [c, d] = coefficients(a);
    return a - c * k[0] - d * k[1];
  }

  /// Returns true if the contact sticks or slides: mu |N| against a direction that a slow velocity does not tell, and
  /// its limit at rest.
  bool may_stick() const { return law_sticks(friction); }
  double limit() const { return static_coefficient_of(friction) * norm(normal); }
  bool takes_energy() const {
    return !std::visit([]<class Law>(const Law&) { return HasForceOfFriction<Law>; }, friction);
  }
  /// Returns the magnitude of the friction, for laws that define one.
  double magnitude(double speed) const {
    return std::visit([&]<class Law>(const Law& law) { return magnitude_again(law, speed, norm(normal)); }, friction);
  }

  /// Returns tau at (t, r).
  Vec3 law(double t, Vec3 r) const {
    return std::visit(
        [&]<class Law>(const Law& law) -> Vec3 {
          if constexpr (HasForceOfFriction<Law>) {
            Vec3 tau{};
            KindOf<Law>::forces(law, {1, t, &r.x, &velocity.x, own.data(), &tau.x, nullptr});
            return tau;
          } else {
            const double speed = norm(velocity);
            return speed > 0.0 ? (-magnitude(speed) / speed) * velocity : Vec3{};
          }
        },
        friction);
  }
};

namespace {

Vec3 to_unit(Vec3 a) {
  const double length = norm(a);
  return length > 0.0 ? (1.0 / length) * a : Vec3{};
}

}  // namespace

void Verifier::verify_friction(const Definitions& definitions) {
  const std::vector<Sliding> contacts = measure_sliding(definitions);
  verify_law(contacts);
  verify_rest(contacts);
  verify_friction_by_blocks();
}

std::vector<Verifier::Sliding> Verifier::measure_sliding(const Definitions& definitions) const {
  const Tangents& tangents = work_.constraints.tangents();
  std::vector<Sliding> contacts;
  bool turns = false;
  for (std::size_t c = 0; c < tangents.size(); ++c) {
    const Tangents::Place& place = tangents[c];
    const Friction& friction = model_.system.friction[static_cast<std::size_t>(place.friction)];
    Sliding& contact = contacts.emplace_back(Sliding{place, friction, tangents.sticks(c)});
    for (std::size_t g = 0; g < static_cast<std::size_t>(place.num_guides); ++g) {
      contact.k[g] = load(K_.data(), place.guide_block[g]);
      contact.own[g] = answer_.lambda[static_cast<std::size_t>(place.guide_row[g])];
    }
    const MovingVec3 u = make_moving(
        std::visit([](const auto& entry) -> const VectorFunction& { return entry.velocity; }, friction)(answer_.t));
    const Vec3 relative = load(answer_.v.data(), place.point) - u.value;
    contact.across = contact.coefficients(relative);
    contact.velocity = contact.along(relative);
    contact.acceleration = load(answer_.w.data(), place.point) - u.first;
    contact.normal = contact.own[0] * contact.k[0] + contact.own[1] * contact.k[1];
    if (reads_full_reaction(friction)) contact.normal = load(answer_.eta.data(), place.point);
    turns = turns || contact.across != std::array{0.0, 0.0};
  }

  // e_j'K_g_dot c follows from phi, which is quadratic in v: (phi(v + s e_j) - phi(v - s e_j))/(4 s), where s is the
  // speed of the neighbourhood.
  if (turns) {
    const Vector zero(n_, 0.0);
    Vector shifted, xi(d_), rate(d_), forward(d_), backward(d_);
    for (std::size_t j = 0; j < 3; ++j) {
      for (const auto& [sign, phi] : {std::pair{1.0, &forward}, std::pair{-1.0, &backward}}) {
        shifted = answer_.v;
        for (std::size_t i = 0; i < model_.num_moving(); ++i) shifted[3 * i + j] += sign * speed_at(i);
        definitions.taylor(model_.parallel, answer_.t, user_r_, to_user(shifted), zero, xi, rate, *phi);
      }
      for (Sliding& contact : contacts) {
        const double s = speed_at(contact.place.point);
        double turn = 0.0;
        for (std::size_t g = 0; g < static_cast<std::size_t>(contact.place.num_guides); ++g) {
          const std::size_t row = user_row(static_cast<std::size_t>(contact.place.guide_row[g]));
          turn += contact.across[g] * (forward[row] - backward[row]) / (4.0 * s);
        }
        (j == 0 ? contact.acceleration.x : j == 1 ? contact.acceleration.y : contact.acceleration.z) -= turn;
      }
    }
  }
  for (Sliding& contact : contacts) contact.acceleration = contact.along(contact.acceleration);
  return contacts;
}

/// Verifies tau = tau(r, v, t, lambda) at each point. A contact that sticks, or slides too slowly to have a direction
/// of its own, takes the rest there, along the guide and of the size given by the law, or below its limit.
void Verifier::verify_law(const std::vector<Sliding>& contacts) {
  const auto has_direction = [&](const Sliding& contact) {
    const double slow = 1e-6 * speed_at(contact.place.point);
    return !contact.may_stick() || (!contact.sticks && norm(contact.velocity) > slow);
  };
  Vector law(n_, 0.0), limit(n_ / 3, 0.0);
  std::vector<int> open(n_ / 3, 0);  // contacts at a point that take the rest
  const auto add = [&](const Sliding& contact, Vec3 tau) {
    store(law.data(), contact.place.point, load(law.data(), contact.place.point) + tau);
  };
  for (const Sliding& contact : contacts) {
    if (has_direction(contact))
      add(contact, contact.law(answer_.t, load(answer_.r.data(), contact.place.point)));
    else
      ++open[static_cast<std::size_t>(contact.place.point)];
  }
  Vector largest(work_.scales.size(), std::numeric_limits<double>::min());
  for (std::size_t i = 0; i < model_.num_moving(); ++i) {
    double& own = largest[work_.scales.of_point(i)];
    own = std::max({own, norm(load(answer_.tau.data(), i)), norm(load(law.data(), i))});
  }

  Worst uphill, above;
  const Vector given = law;
  for (const Sliding& contact : contacts) {
    const auto point = static_cast<std::size_t>(contact.place.point);
    const Vec3 rest = load(answer_.tau.data(), point) - load(given.data(), point);
    Vec3 tau = contact.along(rest);
    if (has_direction(contact)) {
      tau = contact.law(answer_.t, load(answer_.r.data(), point));
    } else if (open[point] > 1) {
      // Two surfaces share the rest in some way of their own; together they may hold the sum of their limits.
      store(law.data(), point, load(answer_.tau.data(), point));
      limit[point] += contact.limit();
      tau = {};
    } else if (contact.sticks) {
      add(contact, tau);
      limit[point] = contact.limit();
    } else {
      // The contact slides from now on, or gave way while others hold it; then it bears its limit.
      const double sliding = contact.magnitude(0.0), limit_of_it = contact.limit();
      const bool is_at_limit = std::abs(norm(tau) - limit_of_it) < std::abs(norm(tau) - sliding);
      tau = (is_at_limit ? limit_of_it : sliding) * to_unit(tau);
      add(contact, tau);
    }
    if (contact.sticks) {
      const double size = model_.mass[point] * at_point(scale_, point);
      above.see((norm(rest) - limit[point]) / size, point);
    }
    if (contact.takes_energy())
      uphill.see(dot(tau, contact.velocity) / (at_point(largest, point) * speed_at(contact.place.point)), point);
  }
  for (std::size_t i = 0; i < n_; ++i) law[i] -= answer_.tau[i];
  const double allowed = refined(rcond_of_S_) + rounding_of_places();
  add_point(&result_.friction, {"tau = tau(r, v, t, lambda) (41)", "law of friction"}, worst_point(law, largest),
            allowed);
  add_point(&result_.friction, {"tau'(v - u) <= 0", "friction against the motion"}, uphill, 1e-10);
  if (something_sticks_)
    add_point(&result_.friction, {"|tau| <= mu_s |N| where it sticks", "limit of static friction"}, above, allowed);
}

/// At rest the law holds for accelerations: a contact that sticks has none, and one that begins to slide moves against
/// tau. One that is about to stop still moves against tau, by more than rounding, and obeys the law of velocities.
void Verifier::verify_rest(const std::vector<Sliding>& contacts) {
  Worst moves, stays, turns;
  bool starts = false;
  for (const Sliding& contact : contacts) {
    const auto point = static_cast<std::size_t>(contact.place.point);
    const Vec3 a = contact.acceleration;
    if (contact.sticks) {
      moves.see(norm(contact.velocity) / speed_at(contact.place.point), point);
      stays.see(norm(a) / at_point(scale_, point), point);
    } else if (contact.may_stick() && norm(contact.velocity) <= 1e-11 * speed_at(contact.place.point)) {
      const Vec3 direction = to_unit(load(answer_.tau.data(), point));
      if (dot(contact.velocity, direction) < -16.0 * eps * speed_at(contact.place.point)) continue;
      starts = true;
      turns.see((norm(a) + dot(a, direction)) / at_point(scale_, point), point);
    }
  }
  const double allowed = 1e-10 + rounding_of_places();
  if (something_sticks_) {
    add_point(&result_.friction, {"T'(v - u) = 0 where it sticks", "rest of velocities where points stick"}, moves,
              1e-9);
    add_point(&result_.friction, {"T'w + phi = 0 where it sticks", "rest of accelerations where points stick"}, stays,
              allowed);
  }
  if (starts)
    add_point(&result_.friction, {"a_t against tau where sliding begins", "direction in which sliding begins"}, turns,
              1e-8);
}

/// Compares the answer, found by the smallest form of (43), with the paper's own three blocks.
void Verifier::verify_friction_by_blocks() {
  constexpr int most_iterations = 60;
  FrictionBlocks blocks{};
  if (answer_.friction.sticking_is_indeterminate) {
    blocks.outcome = {Status::NotUnique, "contacts that stick share their load by convention"};
  } else if (const std::string contact = forms_.normal->contacts()->find_undetermined_reaction(); !contact.empty()) {
    // Each way chooses a share of its own.
    blocks.outcome = {Status::NotUnique,
                      "constraints that depend on each other share the reaction of " + contact + " by convention"};
  } else if (rcond_of_S_ <= 10.0 * eps) {
    blocks.outcome = {Status::NotUnique, "S is singular to rounding: how a load is shared is a convention"};
  } else if (answer_.friction.contraction < 1.0) {
    blocks.outcome =
        iterate_friction_blocks(*forms_.normal, work_, {answer_.t, answer_.r, answer_.v}, most_iterations, &blocks);
  } else {
    blocks.outcome = {Status::NotConverged, "its iteration does not contract here"};
  }
  if (!blocks.outcome.ok()) {
    result_.left_out.push_back("friction found another way: " + blocks.outcome.what);
    return;
  }
  Vector difference = inner_rows(blocks.multipliers), dw(n_, 0.0);
  for (std::size_t a = 0; a < num_rows_; ++a) difference[a] -= is_users(a) ? answer_.lambda[a] : 0.0;
  model_.gather.write_scaled(model_.parallel, K_.data(), difference.data(), model_.inverse_mass.data(),
                             model_.num_moving(), dw.data());
  const double allowed = refined(rcond_of_S_) + rounding_of_places();
  add_point(&result_.friction,
            {"K lambda by (43) = K lambda", "forces of the constraints with friction, found another way"},
            worst_point(dw, scale_), allowed);
}

}  // namespace tanor::detail
