#include "statics/given_equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <variant>

#include "base/text.hpp"

namespace tanor {

namespace {

/// A violation of the constraints above it is no rounding of positions that a file keeps, |xi|/|gradient|/length.
constexpr double allowed_violation = 1e-6;
/// Of what self-stress changes in Z'WZ, over the change of W: beyond rounding.
constexpr double allowed_change = 1e-8;

/// The system at rest and without friction. Throws InputError for what has no small vibrations.
System strip(System system, bool ignore_friction) {
  if (!system.coordinates.empty())
    throw InputError("/coordinates/0", "coordinates take no part in statics; say what can move by constraints alone");
  for (std::size_t k = 0; k < system.friction.size() && !ignore_friction; ++k) {
    if (!std::holds_alternative<Coulomb>(system.friction[k])) continue;
    throw InputError("/friction/" + std::to_string(k),
                     friction_name(system, k) + " is friction, with which a system rests in many places; " +
                         "\"equilibrium\": {\"friction\": \"ignore\"} leaves it out");
  }
  system.friction.clear();
  system.velocities.clear();
  return system;
}

double largest_force(const std::vector<double>& forces, std::size_t num_points, std::size_t* point) {
  double largest = -1.0;
  for (std::size_t i = 0; i < num_points; ++i) {
    const double size = norm(load(forces.data(), i));
    if (size <= largest) continue;
    largest = size;
    *point = i;
  }
  return std::max(largest, 0.0);
}

}  // namespace

GivenEquilibrium::GivenEquilibrium(const System& system, const Claim& claim, const SolverOptions& options)
    : system_(strip(system, claim.ignore_friction)),
      work_(system_, options, claim.time),
      equations_(work_, claim.time),
      r_(3 * system_.num_points()),
      lambda_(model().num_rows(), 0.0) {
  if (claim.positions.size() != r_.size()) {
    throw InputError("", "positions has " + std::to_string(claim.positions.size()) + " numbers; " +
                             std::to_string(r_.size()) + " are needed");
  }
  model().numbering.gather_points(claim.positions, r_, model().parallel);
  std::vector<double> velocities(r_.size());
  work_.prescribe_all(claim.time, r_.data(), velocities.data());
  find_multipliers(claim.multipliers);
  check(claim.force_tolerance);
  equations_.linearise(r_.data(), lambda_.data());

  rank_.rank = equations_.num_rows();
  rank_.degrees_of_freedom = equations_.size() - rank_.rank;
  if (model().may_lose_rank) {
    rank_ = Dynamics(system_, options).rank({.time = claim.time, .positions = claim.positions});
  }
}

/// A factor at a shift that lets no stiffness count: what follows from it is a projection in the norm of M.
KktSolver& GivenEquilibrium::heavy() {
  if (heavy_ != nullptr) return *heavy_;
  const std::span masses = std::span(model().mass).first(model().num_moving());
  const double lightest = masses.empty() ? 1.0 : *std::ranges::min_element(masses);
  double shift = std::max(10.0 * equations_.stiffness().largest() / lightest, 1.0);
  heavy_ = std::make_unique<KktSolver>(equations_, Ordering::Auto);
  while (!heavy_->factorize(shift)) {
    shift *= 10.0;
    if (!std::isfinite(shift)) throw InputError("", "the stiffness at these positions is not finite");
  }
  return *heavy_;
}

void GivenEquilibrium::find_multipliers(std::span<const double> given) {
  const Numbering& numbering = model().numbering;
  if (!given.empty()) {
    if (given.size() != numbering.num_user_rows)
      throw InputError("", "multipliers has " + std::to_string(given.size()) + " numbers; " +
                               std::to_string(numbering.num_user_rows) + " are needed");
    for (std::size_t a = 0; a < lambda_.size(); ++a) lambda_[a] = given[static_cast<std::size_t>(numbering.user_row[a])];
    return;
  }
  std::vector<double> f(equations_.size()), xi(lambda_.size());
  (void)equations_.evaluate(r_.data(), lambda_.data(), f.data(), xi.data());
  equations_.linearise(r_.data(), lambda_.data());
  lambda_ = balance(&f);
}

std::vector<double> GivenEquilibrium::balance(std::vector<double>* f) {
  std::vector<double> multipliers(lambda_.size(), 0.0);
  // M w - f = K lambda, K'w = 0, but for the stiffness that hardly counts; what it leaves is balanced again.
  constexpr int rounds = 3;
  for (int k = 0; k < rounds && !multipliers.empty(); ++k) {
    std::vector<double> x = *f, y(lambda_.size(), 0.0);
    heavy().solve(x.data(), y.data());
    for (std::size_t a = 0; a < y.size(); ++a) {
      y[a] = -y[a];
      multipliers[a] += y[a];
    }
    equations_.add_reactions(y.data(), f->data());
  }
  return multipliers;
}

void GivenEquilibrium::project(std::vector<double>* x) {
  for (std::size_t i = 0; i < x->size(); ++i) (*x)[i] *= model().mass[i / 3];
  std::vector<double> y(lambda_.size(), 0.0);
  heavy().solve(x->data(), y.data());
  double size = 0.0;
  for (const double value : *x) size = std::max(size, std::abs(value));
  for (double& value : *x) value /= size > 0.0 ? size : 1.0;
}

void GivenEquilibrium::check(double force_tolerance) {
  std::vector<double> g(equations_.size()), xi(lambda_.size());
  const double scale = equations_.evaluate(r_.data(), lambda_.data(), g.data(), xi.data());
  if (!std::isfinite(scale)) throw InputError("", model().not_finite(equations_.time()).what);
  if (const double violation = work_.position_violation(equations_.time(), r_.data()); violation > allowed_violation) {
    throw InputError("", "the positions are no equilibrium: they break the constraints by " + text(violation) +
                             " of a length; find_equilibrium, or tanor equilibrium, finds one");
  }
  std::size_t worst = 0;
  const double left = largest_force(g, model().num_moving(), &worst);
  relative_residual_ = scale > 0.0 ? left / scale : 0.0;
  if (relative_residual_ <= force_tolerance) return;
  const Vec3 at = load(r_.data(), worst);
  throw InputError("", "the positions are no equilibrium: nothing balances " + text(left) + " N at point " +
                           std::to_string(model().numbering.user_point[worst]) + " (" + text(at.x) + ", " + text(at.y) +
                           ", " + text(at.z) + "), " + text(relative_residual_) + " of the largest force; at most " +
                           text(force_tolerance) + " passes; find_equilibrium, or tanor equilibrium, finds one");
}

/// nu with K nu = 0, for unit gradients in the norm of M^-1: that of a dependence.
std::vector<double> GivenEquilibrium::self_stress(const RowDependence& dependence) const {
  std::vector<double> squares(lambda_.size(), 0.0), result(lambda_.size(), 0.0);
  for (const Incidence& incidence : model().incidences) {
    squares[static_cast<std::size_t>(incidence.row)] +=
        model().inverse_mass[static_cast<std::size_t>(incidence.point)] *
        squared(load(equations_.gradients().data(), incidence.block));
  }
  std::vector<std::size_t> inner(lambda_.size());
  for (std::size_t a = 0; a < inner.size(); ++a) inner[static_cast<std::size_t>(model().numbering.user_row[a])] = a;
  const auto set = [&](std::size_t row, double coefficient) {
    const std::size_t a = inner[row];
    if (squares[a] > 0.0) result[a] = coefficient / std::sqrt(squares[a]);
  };
  set(dependence.row, 1.0);
  for (const RowDependence::Term& term : dependence.terms) set(term.row, -term.coefficient);
  return result;
}

/// Z'(W(lambda + nu) - W(lambda))Z is 0 where it takes a random z = Zq to what K alone can balance.
std::string GivenEquilibrium::find_ambiguous_stiffness() {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  std::string names;
  std::vector<double> z(equations_.size());
  for (double& value : z) value = normal(generator);
  if (!rank_.dependences.empty()) project(&z);
  for (const RowDependence& dependence : rank_.dependences) {
    if (dependence.terms.empty()) continue;
    std::vector<double> nu = self_stress(dependence);
    std::vector<double> with(z.size()), without(z.size());
    equations_.stiffness().multiply(z.data(), without.data());
    for (std::size_t a = 0; a < nu.size(); ++a) nu[a] += lambda_[a];
    equations_.linearise(r_.data(), nu.data());
    equations_.stiffness().multiply(z.data(), with.data());
    equations_.linearise(r_.data(), lambda_.data());
    for (std::size_t i = 0; i < with.size(); ++i) with[i] -= without[i];
    std::size_t point = 0;
    const double change = largest_force(with, model().num_moving(), &point);
    (void)balance(&with);
    const double left = largest_force(with, model().num_moving(), &point);
    if (left > allowed_change * change && change > 0.0) names += (names.empty() ? "" : "; ") + dependence.what;
  }
  return names;
}

}  // namespace tanor
