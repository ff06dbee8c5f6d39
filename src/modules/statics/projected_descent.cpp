#include "statics/projected_descent.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/nearest_point.hpp"
#include "dynamics/projector.hpp"

namespace tanor::detail {

namespace {

// Bitzek et al. 2006, Table I.
constexpr double growth = 1.1, shrinking = 0.5, first_mixing = 0.1, mixing_decay = 0.99;
constexpr int patience = 5;
/// Ratio of the tangential force to the largest force at which Newton's method takes over.
constexpr double near = 1e-3;

/// Projects the start onto xi = 0. At a configuration of perfect symmetry the projection fails, and it starts again
/// from disturbed positions.
Outcome find_start(EquilibriumEquations& equations, Linearization& linearization, Projector& projector,
                   std::vector<double>* r) {
  if (equations.model().num_rows() == 0) return {};
  NearestPoint nearest(equations.work(), linearization, projector);
  const std::vector<double> given = *r;
  ProjectionReport start = nearest.find(equations.time(), r->data());
  if (start.outcome.ok()) return {};
  std::copy_n(given.begin(), equations.size(), r->begin());
  equations.disturb(0.1 * equations.model().smallest_length, r->data());
  return nearest.find(equations.time(), r->data()).outcome;
}

}  // namespace

Outcome descend_along_constraints(EquilibriumEquations& equations, SmallestMultipliers& multipliers,
                                  const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals,
                                  int* iterations) {
  const Model& model = equations.model();
  const double t = equations.time();
  const std::size_t size = equations.size();
  Linearization& linearization = multipliers.linearization();
  Residuals beside(equations.work(), linearization.blocks());
  Projector projector(equations.work(), linearization, beside);
  std::vector<double>& r = state->r;
  if (Outcome outcome = find_start(equations, linearization, projector, &r); !outcome.ok()) return outcome;
  std::vector<double> g(size), xi(model.num_rows()), rates(xi.size()), v(r.size(), 0.0);
  const std::vector<double> zero(model.num_rows(), 0.0);
  double dt = 0.0, longest_dt = 0.0, mixing = first_mixing;
  int downhill = 0;
  for (int step = 0; step < limits.max_iterations; ++step, ++*iterations) {
    if (Outcome outcome = multipliers.find(r, zero, &state->lambda); !outcome.ok()) return outcome;
    if (!rates.empty()) {
      // Projects v onto the tangent space of xi = 0, with the current factor of S.
      (void)linearization.apply_transposed(v.data(), nullptr, rates.data());
      linearization.correct(rates.data(), v.data());
    }
    const double scale = equations.evaluate(r.data(), state->lambda.data(), g.data(), xi.data());
    double force = 0.0, power = 0.0, speed2 = 0.0, slope2 = 0.0, fastest = 0.0;
    for (std::size_t i = 0; i < model.num_moving(); ++i) {
      const Vec3 here = load(g.data(), i), b = load(v.data(), i), a = model.inverse_mass[i] * here;
      force = larger(force, norm(here));
      fastest = std::max(fastest, norm(a));
      power += dot(here, b);
      speed2 += model.mass[i] * dot(b, b);
      slope2 += model.mass[i] * dot(a, a);
    }
    residuals->push_back(force);
    if (!std::isfinite(force + scale)) return model.not_finite(t);
    if (force <= near * scale) return {};
    if (dt == 0.0) {
      dt = 0.1 * std::sqrt(model.smallest_length / fastest);
      longest_dt = 10.0 * dt;
    }
    if (power > 0.0) {
      if (++downhill > patience) {
        dt = std::min(growth * dt, longest_dt);
        mixing *= mixing_decay;
      }
    } else if (speed2 > 0.0) {
      downhill = 0;
      dt *= shrinking;
      mixing = first_mixing;
      std::fill(v.begin(), v.end(), 0.0);
      speed2 = 0.0;
    }
    // v = (1 - mixing) v + mixing |v| a/|a| + dt a
    const double towards = slope2 > 0.0 ? mixing * std::sqrt(speed2 / slope2) : 0.0;
    for (std::size_t i = 0; i < size; ++i)
      v[i] = (1.0 - mixing) * v[i] + (towards + dt) * model.inverse_mass[i / 3] * g[i];
    // A step moves points by at most a tenth of the shortest length.
    const double longest = dt * model.largest_norm(v.data());
    const double length = dt * std::min(1.0, 0.1 * model.smallest_length / std::max(longest, 1e-300));
    for (std::size_t i = 0; i < size; ++i) r[i] += length * v[i];
    if (ProjectionReport report = projector.project_positions(t, r.data()); !report.outcome.ok()) return report.outcome;
  }
  return {};
}

}  // namespace tanor::detail
