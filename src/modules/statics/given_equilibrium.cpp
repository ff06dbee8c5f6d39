#include "statics/given_equilibrium.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "base/text.hpp"
#include "base/with_unit.hpp"
#include "dynamics/prestress_rigidity.hpp"
#include "statics/kkt_solver.hpp"
#include "statics/newton_descent.hpp"
#include "statics/standing_corner.hpp"
#include "statics/unsymmetric_kkt.hpp"

namespace tanor::detail {

namespace {

/// Violation |xi|/|gradient|/length that rounding of stored positions may cause; more is another configuration.
constexpr double allowed_violation = 1e-6;
/// Rounding error of a change of y'Wz by self-stress for moves y and z, relative to the terms of that change.
constexpr double allowed_change = 1e-8;

constexpr const char* advice = "; find_equilibrium, or tanor equilibrium, finds one";

}  // namespace

GivenEquilibrium::GivenEquilibrium(const System& system, const EquilibriumClaim& claim,
                                   const EquilibriumOptions& options)
    : input_(system, options),
      work_(input_.system, options.solver, 0.0),
      equations_(work_, options.at, input_.frame.spin),
      smallest_(equations_, options.solver),
      r_(3 * model().num_points()),
      lambda_(model().num_rows(), 0.0),
      residuals_(model().num_moving(), 0.0) {
  check_size(claim.positions.size(), r_.size(), "positions");
  model().numbering.gather_points(claim.positions, r_, model().parallel);
  work_.set_time(options.at);
  std::vector<double> velocities(r_.size());
  work_.prescribe_all(options.at, r_.data(), velocities.data());
  find_multipliers(claim.multipliers);
}

std::unique_ptr<GivenEquilibrium> GivenEquilibrium::stand_at(System system, const EquilibriumClaim& claim,
                                                             const EquilibriumOptions& options) {
  (void)take_sides(&system, options);  // what is closed at rest holds both sides
  const auto make = [&](const System& held) { return std::make_unique<GivenEquilibrium>(held, claim, options); };
  const auto find = [&](GivenEquilibrium& state) {
    const std::string complaint = state.find_complaint(claim.force_tolerance);
    if (complaint.empty()) return std::vector<Index>();
    std::vector<Index> rigid;
    if (options.prestress.empty())
      rigid = find_prestress_rigid_points(state.model().system, state.smallest_.rank().dependences);
    if (rigid.empty()) throw NotAtRest("", complaint);
    return rigid;
  };
  std::vector<Index> rigid;
  std::unique_ptr<GivenEquilibrium> state = make_without_rigid_points(std::move(system), make, find, &rigid);
  if (!rigid.empty()) state->input_.left_out.push_back(describe_rigid_points(rigid));
  state->linearise(state->lambda_);
  return state;
}

void GivenEquilibrium::find_multipliers(std::span<const double> given) {
  const Numbering& numbering = model().numbering;
  std::vector<double> prestress(lambda_.size());
  for (std::size_t a = 0; a < lambda_.size(); ++a)
    prestress[a] = input_.prestress[static_cast<std::size_t>(numbering.user_row[a])];
  if (Outcome outcome = smallest_.find_and_decide(r_, prestress, &lambda_, &rank_); !outcome.ok())
    throw InputError("", outcome.what);
  note_useless_prestress(prestress, rank_.dependences.size(), &input_.left_out);
  if (given.empty()) {
    if (rank_.dependences.empty()) return;
    std::vector<double> g(equations_.size()), xi(lambda_.size());
    (void)equations_.evaluate(r_.data(), lambda_.data(), g.data(), xi.data());
    note_changed_prestress(equations_, prestress, lambda_, &input_.left_out);
    return;
  }
  check_size(given.size(), numbering.num_user_rows, "multipliers");
  // Multipliers of rows that join only supports, or points that prestress holds rigid, are undetermined: they are NaN.
  for (std::size_t a = 0; a < equations_.num_rows(); ++a) {
    const double each = given[static_cast<std::size_t>(numbering.user_row[a])];
    if (!std::isnan(each)) lambda_[a] = each;
  }
}

std::string GivenEquilibrium::name_worst_row() {
  const std::vector<double> at_rest(r_.size(), 0.0);
  std::vector<double> violation(lambda_.size()), rate(lambda_.size());
  work_.constraints.measure(r_.data(), at_rest.data(), violation.data(), rate.data());
  const auto worst = std::ranges::max_element(violation, {}, [](double each) { return std::abs(each); });
  return work_.name_row(static_cast<std::size_t>(worst - violation.begin()));
}

std::string GivenEquilibrium::find_complaint(double force_tolerance) {
  std::vector<double> g(equations_.size()), xi(lambda_.size());
  const double scale = equations_.evaluate(r_.data(), lambda_.data(), g.data(), xi.data());
  if (!std::isfinite(scale)) throw InputError("", model().not_finite(equations_.time()).what);
  if (equations_.violation() > allowed_violation) {
    throw NotAtRest("", "the positions are no equilibrium: they break " + name_worst_row() + " by " +
                            text(equations_.violation()) + " of a length" + advice);
  }
  std::vector<double> users(r_.size());
  model().numbering.scatter_points(r_, users);
  if (std::string corner = find_standing_corner(model().system, equations_.time(), users, users); !corner.empty())
    throw InputError("", "the points stand in " + corner + ", where no side of it holds");
  for (std::size_t i = 0; i < residuals_.size(); ++i) residuals_[i] = norm(load(g.data(), i));
  if (g.empty() || scale == 0.0) return {};
  // If every single force vanishes, as in a molecule at rest, the residual is rounding of the positions.
  linearise(lambda_);
  std::size_t worst = 0;
  const auto known = [&](std::size_t i) {
    return residuals_[i] <= equations_.rounding_of_forces(i) ? 0.0 : residuals_[i];
  };
  for (std::size_t i = 1; i < residuals_.size(); ++i) worst = known(i) > known(worst) ? i : worst;
  const double left = known(worst);
  if (left <= force_tolerance * scale) return {};
  // If all forces are small beside those that a move of the scene's size makes, the largest one is no scale: the
  // residual is small where rest is near.
  const double step = find_next_step(g, xi, scale), scene_size = model().scene_size;
  const double of_largest = force_tolerance * scale, allowed_step = force_tolerance * scene_size,
               of_stiffness = std::isfinite(step) ? allowed_step * equations_.stiffness().largest_of(worst) : 0.0;
  const bool is_step_decisive = left <= of_stiffness;
  if (is_step_decisive && step <= allowed_step) return {};
  const double limit = std::max(of_largest, of_stiffness);
  const auto [left_text, limit_text] = texts_apart<2>({left, limit});
  const auto [step_text, allowed_text] = texts_apart<2>({step, allowed_step});
  const Vec3 at = load(r_.data(), worst);
  const Units& units = model().system.units;
  const std::string what = "the positions are no equilibrium: nothing balances " + with_unit(left_text, units.force) +
                           " at point " + std::to_string(model().numbering.user_point[worst]) + " (" + text(at.x) +
                           ", " + text(at.y) + ", " + text(at.z) + ")",
                    part = ", " + text(force_tolerance) + " of ",
                    moves = "Newton's method would move points by " + with_unit(step_text, units.length);
  if (is_step_decisive)
    return what + ", and " + moves + ", where at most " + with_unit(allowed_text, units.length) + part +
           "the size of the scene, is allowed" + advice;
  return what + ", where at most " + with_unit(limit_text, units.force) + part +
         (of_largest >= of_stiffness ? "the largest force" : "its stiffness times the size of the scene") +
         ", is allowed" + (std::isfinite(step) ? "; " + moves : "") + advice;
}

/// Returns the length of Newton's step to the equilibrium, m, with each coordinate held by a small spring; infinite if
/// there is none.
double GivenEquilibrium::find_next_step(std::vector<double> g, std::vector<double> xi, double scale) {
  linearise(lambda_);
  equations_.stiffness().hold_rows(held_rows, held_rows * scale / model().scene_size);
  UnsymmetricKkt kkt(equations_);
  for (double& each : xi) each = -each;
  if (!kkt.factorize(0.0)) return std::numeric_limits<double>::infinity();
  kkt.solve(&g, &xi);
  const double step = longest(g);
  return std::isfinite(step) ? step : std::numeric_limits<double>::infinity();
}

/// Returns nu with K nu = 0. A dependence refers to gradients of unit length in the norm of M^-1.
std::vector<double> GivenEquilibrium::self_stress(const RowDependence& dependence) const {
  std::vector<double> squares(lambda_.size(), 0.0), result(lambda_.size(), 0.0);
  for (const Incidence& incidence : model().incidences) {
    squares[static_cast<std::size_t>(incidence.row)] +=
        model().inverse_mass[static_cast<std::size_t>(incidence.point)] *
        squared(load(equations_.gradients().data(), incidence.block));
  }
  for (std::size_t a = 0; a < lambda_.size(); ++a) {
    const auto row = static_cast<std::size_t>(model().numbering.user_row[a]);
    double coefficient = row == dependence.row ? 1.0 : 0.0;
    for (const RowDependence::Term& term : dependence.terms) {
      if (term.row == row) coefficient = -term.coefficient;
    }
    if (squares[a] > 0.0) result[a] = coefficient / std::sqrt(squares[a]);
  }
  return result;
}

/// Returns fixed-seed random x [3 moving] with K'x = 0. They solve M x + K mu = M random, with a mass shift so large
/// that stiffness hardly counts.
std::vector<std::vector<double>> GivenEquilibrium::random_moves(std::size_t count) {
  std::mt19937 generator(7);
  std::normal_distribution<double> normal;
  const std::span<const double> masses(model().mass.data(), model().num_moving());
  double shift = std::max(10.0 * equations_.stiffness().largest() / *std::ranges::min_element(masses), 1.0);
  KktSolver kkt(equations_);
  while (!kkt.factorize(shift) && std::isfinite(shift)) shift *= 10.0;
  std::vector<std::vector<double>> moves(count, std::vector<double>(equations_.size()));
  for (std::vector<double>& x : moves) {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = model().mass[i / 3] * normal(generator);
    std::vector<double> rows(lambda_.size(), 0.0);
    (void)kkt.solve(x.data(), rows.data());
    const double length = std::sqrt(dot(x, x));
    for (double& value : x) value /= length;
  }
  return moves;
}

bool GivenEquilibrium::feels_coriolis() {
  if (!input_.frame.turns() || degrees_of_freedom() == 0) return false;
  const std::vector<std::vector<double>> moves = random_moves(2);
  const double twice_spin = 2.0 * norm(input_.frame.spin);
  // y'Gz, and a bound of its terms
  double sum = 0.0, terms = 0.0;
  for (std::size_t i = 0; i < model().num_moving(); ++i) {
    const Vec3 y = load(moves[0].data(), i), z = load(moves[1].data(), i);
    sum += 2.0 * model().mass[i] * dot(y, cross(input_.frame.spin, z));
    terms += twice_spin * model().mass[i] * norm(y) * norm(z);
  }
  return std::abs(sum) > allowed_change * terms;
}

std::string GivenEquilibrium::find_ambiguous_stiffness() {
  std::vector<std::string> found;
  if (std::ranges::all_of(rank_.dependences, [](const RowDependence& each) { return each.terms.empty(); }) ||
      degrees_of_freedom() == 0)
    return {};
  const std::vector<std::vector<double>> moves = random_moves(2);
  const StiffnessMatrix without = equations_.stiffness();
  // The self-stress is so large that rounding of W is negligible beside it.
  const double large = std::max(1.0, without.largest() * model().smallest_length);
  for (const RowDependence& dependence : rank_.dependences) {
    if (dependence.terms.empty()) continue;
    std::vector<double> lambda = self_stress(dependence);
    for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] = lambda_[a] + large * lambda[a];
    linearise(lambda);
    // y'(W(lambda + nu) - W(lambda))z
    const StiffnessMatrix::Work change = equations_.stiffness().find_work(moves[0].data(), moves[1].data(), &without);
    if (std::abs(change.sum) > allowed_change * change.terms) found.push_back(dependence.what);
  }
  linearise(lambda_);
  return name_some(found, "; ", "; and ");
}

}  // namespace tanor::detail
