#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <variant>

#include <tanor/modes.hpp>

#include "base/numbers.hpp"
#include "base/quiet_traps.hpp"
#include "statics/given_equilibrium.hpp"
#include "statics/mode_finder.hpp"

namespace tanor {
using namespace detail;
using Eigen::VectorXd;

namespace {

/// Load factors below the first count as zero, those above the second as infinite.
constexpr double least_factor = 1e-9, most_factor = 1e12;
/// Part of the scale of omega^2 by which masses shift W(p) if motions cost nothing without load; W(p) then has a
/// factor.
constexpr double little_mass = 1e-9;
/// The critical factor is bracketed to this ratio; inverse iteration does the rest.
constexpr double bracket = 1.1;
constexpr int most_iterations = 200;
constexpr double rounding_of_factor = 1e-14, settled = 1e-11;
/// Rounding error of both stiffnesses, relative to their terms, above which the load factor has no correct digits.
constexpr double too_much_rounding = 1e-4;

System without_loads(const System& system, const std::vector<std::string>& loads) {
  System result = system;
  result.forces.clear();
  std::vector<bool> is_found(loads.size(), false);
  for (std::size_t k = 0; k < system.forces.size(); ++k) {
    const Force& force = system.forces[k];
    const auto name = std::ranges::find(loads, force_name(system, k));
    if (name == loads.end()) {
      result.forces.push_back(force);
      continue;
    }
    is_found[static_cast<std::size_t>(name - loads.begin())] = true;
    if (!std::holds_alternative<Gravity>(force) && !std::holds_alternative<ConstantForce>(force))
      throw InputError("/modes/buckling", "'" + *name + "' is of kind " + std::string(kind_name(force)) +
                                              "; loads that a factor multiplies are gravity and constant ones");
  }
  const auto missing = std::ranges::find(is_found, false);
  if (loads.empty() || missing != is_found.end())
    throw InputError("/modes/buckling",
                     "no force has the name '" +
                         (loads.empty() ? "" : loads[static_cast<std::size_t>(missing - is_found.begin())]) + "'");
  return result;
}

/// The stiffness Z'W(p)Z at a fixed shape, at which the multipliers and so W are linear in the load factor p.
class LoadedStiffness {
 public:
  /// `state` is the equilibrium under the load; lambda_0 are the multipliers without it.
  LoadedStiffness(GivenEquilibrium* state, std::vector<double> lambda_0)
      : state_(*state),
        lambda_0_(std::move(lambda_0)),
        lambda_1_(state->multipliers()),
        W_0_(evaluate(lambda_0_)),
        kkt_(state->equations()) {
    if (!kkt_.factorize(0.0)) shift_ = little_mass * ModeFinder(state->equations(), kkt_, 0).scale();
  }

  /// Returns true if W(p) + s M is positive definite where K'x = 0; the solver then has its factor.
  bool is_stable_at(double p) {
    // lambda = lambda_0 + p (lambda_1 - lambda_0)
    std::vector<double> lambda(lambda_0_);
    for (std::size_t a = 0; a < lambda.size(); ++a) lambda[a] += p * (lambda_1_[a] - lambda_0_[a]);
    state_.linearise(lambda);
    return kkt_.factorize(shift_);
  }
  /// Returns W(0) x, and the contribution of the load, (W(p) - W(0)) x, at the last p.
  std::pair<VectorXd, VectorXd> multiply(const VectorXd& x) const {
    const VectorXd without = W_0_.multiply(x);
    return {without, state_.equations().stiffness().multiply(x) - without};
  }
  /// Returns the sum of the absolute terms of x'W(0)x.
  double sum_terms(const VectorXd& x) const { return W_0_.find_work(x.data(), x.data()).terms; }
  /// Computes x := (W(p) + s M)^-1 x where K'x = 0, at the last p that was stable.
  void solve(VectorXd* x) {
    std::vector<double> y(lambda_0_.size(), 0.0);
    kkt_.solve(x->data(), y.data());
  }

 private:
  StiffnessMatrix evaluate(const std::vector<double>& lambda) {
    state_.linearise(lambda);
    return state_.equations().stiffness();
  }

  GivenEquilibrium& state_;
  std::vector<double> lambda_0_, lambda_1_;  // without the load, under it
  StiffnessMatrix W_0_;
  KktSolver kkt_;
  double shift_ = 0.0;  // s, 1/s^2
};

Buckling refuse_buckling(Status status, std::string what) {
  return {{status, std::move(what)}, {}, {}};
}

/// Returns the largest stable load factor of a bracket [low, low * bracket] of the critical one. Returns 0 if the
/// system is unstable without load, and infinity if no load buckles it.
double find_stable_factor(LoadedStiffness* stiffness) {
  double low = 1.0, high = 1.0;
  if (stiffness->is_stable_at(1.0)) {
    while (stiffness->is_stable_at(high *= 8.0)) {
      low = high;
      if (high > most_factor) return std::numeric_limits<double>::infinity();
    }
  } else {
    while (!stiffness->is_stable_at(low /= 8.0)) {
      high = low;
      if (low < least_factor) return 0.0;
    }
  }
  while (high > bracket * low) {
    const double middle = std::sqrt(low * high);
    (stiffness->is_stable_at(middle) ? low : high) = middle;
  }
  return low;
}

/// Refines the critical factor by inverse iteration with the factor of a stable p, `low`, on W_0 x = -p W_1 x, and
/// Rayleigh's quotient. The changes fall until rounding is left, which is large if bending is a small difference of
/// large terms. Returns nothing if the iteration does not settle.
std::optional<double> refine(LoadedStiffness* stiffness, double low, VectorXd* x) {
  double factor = low, last_change = std::numeric_limits<double>::infinity();
  for (int k = 0; k < most_iterations; ++k) {
    // (W_0 + low W_1 + s M) y = -low W_1 x
    const auto [W0x, by_load] = stiffness->multiply(*x);
    const double before = factor, work_of_load = x->dot(by_load);
    if (k > 0) factor = -low * x->dot(W0x) / work_of_load;
    const double change = std::abs(factor - before) / std::abs(factor);
    const double rounding = eps * stiffness->sum_terms(*x) / std::abs(work_of_load);
    if (k > 1 && (change <= rounding_of_factor || (change <= settled + rounding && change >= last_change)))
      return rounding <= too_much_rounding ? std::optional(factor) : std::nullopt;
    if (k > 1) last_change = change;
    *x = -by_load;
    stiffness->solve(x);
    x->normalize();
  }
  return std::nullopt;
}

/// Finds the buckling of a system whose constraints all act both ways.
Buckling find_buckling_of(const System& system, std::span<const double> positions, const BucklingOptions& options) {
  const EquilibriumOptions same = system_options(options);
  const EquilibriumClaim claim{positions, {}, options.force_tolerance};
  const std::unique_ptr<GivenEquilibrium> loaded = GivenEquilibrium::stand_at(system, claim, same);
  GivenEquilibrium& state = *loaded;
  std::unique_ptr<GivenEquilibrium> unloaded;
  const System rest = without_loads(system, options.loads);
  try {
    unloaded = GivenEquilibrium::stand_at(rest, claim, same);
  } catch (const InputError& error) {
    return refuse_buckling(Status::NoSolution,
                           "the shape moves with the load, so that its stiffness is not linear in the load "
                           "factor: without it " +
                               std::string(error.what()));
  }
  // Points that a load holds rigid by prestress can move without it.
  if (unloaded->equations().size() != state.equations().size())
    return refuse_buckling(Status::NoSolution,
                           "the load holds points rigid by prestress, which no load factor multiplies");
  if (const std::string rows = state.find_ambiguous_stiffness(); !rows.empty())
    return refuse_buckling(Status::NotUnique,
                           "the stiffness depends on a self-stress that forces do not determine (" + rows + ")");
  if (state.degrees_of_freedom() == 0) return {{}, std::numeric_limits<double>::infinity(), {}};

  LoadedStiffness stiffness(&state, unloaded->multipliers());
  const double low = find_stable_factor(&stiffness);
  if (low == 0.0) return refuse_buckling(Status::NoSolution, "it is unstable without the load too");
  if (std::isinf(low)) return {{}, std::numeric_limits<double>::infinity(), {}};
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  const VectorXd mass = state.equations().masses();
  VectorXd x(mass.size());
  for (double& value : x) value = normal(generator);
  (void)stiffness.is_stable_at(low);
  stiffness.solve(&x);
  const std::optional<double> factor = refine(&stiffness, low, &x);
  if (!factor)
    return refuse_buckling(Status::NotConverged, "inverse iteration does not settle at the load that buckles it");
  x /= std::sqrt(x.dot(mass.cwiseProduct(x)));
  std::vector<double> shape(x.begin(), x.end()), users(3 * system.num_points());
  shape.resize(users.size(), 0.0);
  state.model().numbering.scatter_points(shape, users);
  return {{}, *factor, std::move(users)};
}

}  // namespace

Buckling find_buckling(const System& system, std::span<const double> positions, const BucklingOptions& options) {
  const QuietTraps quiet;
  return find_with_closed(system, positions, options, [&](const System& held, const BucklingOptions& chosen) {
    return find_buckling_of(held, positions, chosen);
  });
}

}  // namespace tanor
