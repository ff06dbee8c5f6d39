#include "statics/projected_descent.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/nearest_point.hpp"

namespace tanor::detail {

namespace {

// Bitzek et al. 2006, Table I.
constexpr double growth = 1.1, shrinking = 0.5, first_mixing = 0.1, mixing_decay = 0.99;
constexpr int patience = 5;
/// Ratio of the tangential force to the largest force at which Newton's method takes over.
constexpr double near = 1e-3;

}  // namespace

/// Projects the start onto xi = 0. At a configuration of perfect symmetry the projection fails, and it starts again
/// from disturbed positions.
Outcome ProjectedDescent::find_start(Projector& projector, std::vector<double>* r) {
  if (model_.num_rows() == 0) return {};
  NearestPoint nearest(equations_.work(), multipliers_.linearization(), projector);
  const std::vector<double> given = *r;
  ProjectionReport start = nearest.find(equations_.time(), r->data());
  if (start.outcome.ok()) return {};
  std::copy_n(given.begin(), equations_.size(), r->begin());
  equations_.disturb(0.1 * model_.smallest_length, r->data());
  return nearest.find(equations_.time(), r->data()).outcome;
}

/// Projects v onto the tangent space of xi = 0, with the current factor of S.
void ProjectedDescent::turn_along_constraints(std::vector<double>* v) {
  if (model_.num_rows() == 0) return;
  rates_.resize(model_.num_rows());
  (void)multipliers_.linearization().apply_transposed(v->data(), nullptr, rates_.data());
  multipliers_.linearization().correct(rates_.data(), v->data());
}

Outcome ProjectedDescent::run(const NewtonLimits& limits, StaticState* state, std::vector<double>* residuals) {
  const double t = equations_.time();
  const std::size_t size = equations_.size();
  Linearization& linearization = multipliers_.linearization();
  Residuals beside(equations_.work(), linearization.blocks());
  Projector projector(equations_.work(), linearization, beside);
  std::vector<double>& r = state->r;
  if (Outcome outcome = find_start(projector, &r); !outcome.ok()) return outcome;
  std::vector<double> g(size), xi(model_.num_rows()), v(r.size(), 0.0);
  const std::vector<double> zero(model_.num_rows(), 0.0);
  double dt = 0.0, longest_dt = 0.0, mixing = first_mixing;
  int downhill = 0;
  for (iterations_ = 0; iterations_ < limits.max_iterations; ++iterations_) {
    if (Outcome outcome = multipliers_.find(r, zero, &state->lambda); !outcome.ok()) return outcome;
    turn_along_constraints(&v);
    const double scale = equations_.evaluate(r.data(), state->lambda.data(), g.data(), xi.data());
    double force = 0.0, power = 0.0, speed2 = 0.0, slope2 = 0.0, fastest = 0.0;
    for (std::size_t i = 0; i < model_.num_moving(); ++i) {
      const Vec3 here = load(g.data(), i), b = load(v.data(), i), a = model_.inverse_mass[i] * here;
      force = larger(force, norm(here));
      fastest = std::max(fastest, norm(a));
      power += dot(here, b);
      speed2 += model_.mass[i] * dot(b, b);
      slope2 += model_.mass[i] * dot(a, a);
    }
    residuals->push_back(force);
    if (!std::isfinite(force + scale)) return model_.not_finite(t);
    if (force <= near * scale) return {};
    if (dt == 0.0) {
      dt = 0.1 * std::sqrt(model_.smallest_length / fastest);
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
      v[i] = (1.0 - mixing) * v[i] + (towards + dt) * model_.inverse_mass[i / 3] * g[i];
    // A step moves points by at most a tenth of the shortest length.
    const double longest = dt * model_.largest_norm(v.data());
    const double step = dt * std::min(1.0, 0.1 * model_.smallest_length / std::max(longest, 1e-300));
    for (std::size_t i = 0; i < size; ++i) r[i] += step * v[i];
    if (ProjectionReport report = projector.project_positions(t, r.data()); !report.outcome.ok()) return report.outcome;
  }
  return {};
}

}  // namespace tanor::detail
