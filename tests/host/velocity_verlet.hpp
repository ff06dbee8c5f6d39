#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <tanor/constrainer.hpp>

/// \file A host as hosts are: with its own arrays, forces and time loop.
namespace tanor::host {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Velocity Verlet with constraints by a Constrainer. Forces and potential are functions of the positions.
struct Host {
  std::vector<double> masses, r, v;
  std::function<void(const std::vector<double>&, std::vector<double>*)> set_forces;
  std::function<double(const std::vector<double>&)> potential;
  Constrainer constrainer;
  std::vector<double> f, old;
  Outcome outcome;
  int iterations = 0;      // of all steps
  double violation = 0.0;  // largest of all steps
  bool measures = false;

  Host(const Host&) = delete;  // its forces know where it is
  Host(std::vector<double> m, std::vector<double> positions, std::vector<Constraint> constraints,
       const SolverOptions& options = {.threads = 1})
      : masses(std::move(m)),
        r(std::move(positions)),
        v(r.size(), 0.0),
        set_forces([](const auto&, std::vector<double>* forces) { std::fill(forces->begin(), forces->end(), 0.0); }),
        potential([](const auto&) { return 0.0; }),
        constrainer(masses, std::move(constraints), r, options),
        f(r.size()),
        old(r.size()) {}

  bool moves(std::size_t k) const { return masses[k / 3] < infinity; }
  /// Makes the velocities obey the constraints and evaluates the first forces.
  void start() {
    outcome = constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome;
    set_forces(r, &f);
  }
  void kick(double time) {
    for (std::size_t k = 0; k < v.size(); ++k) v[k] += moves(k) ? time * f[k] / masses[k / 3] : 0.0;
  }
  bool step(double h) {
    old = r;
    kick(0.5 * h);
    for (std::size_t k = 0; k < r.size(); ++k) r[k] += moves(k) ? h * v[k] : 0.0;
    ConstraintReport report = constrainer.constrain_positions(
        {.step = h, .old_positions = old, .positions = r, .velocities = v, .measures = measures});
    iterations += report.iterations;
    violation = std::max(violation, report.violation);
    if (outcome = std::move(report.outcome); !outcome.ok()) return false;
    set_forces(r, &f);
    kick(0.5 * h);
    outcome =
        constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v, .measures = measures}).outcome;
    return outcome.ok();
  }
  double kinetic() const {
    double sum = 0.0;
    for (std::size_t k = 0; k < v.size(); ++k) sum += moves(k) ? 0.5 * masses[k / 3] * v[k] * v[k] : 0.0;
    return sum;
  }
  double energy() const { return kinetic() + potential(r); }

  void set_gravity(double g) {
    set_forces = [this, g](const auto&, std::vector<double>* forces) {
      for (std::size_t i = 0; i < masses.size(); ++i) (*forces)[3 * i + 1] = moves(3 * i) ? -g * masses[i] : 0.0;
    };
    potential = [this, g](const std::vector<double>& at) {
      double sum = 0.0;
      for (std::size_t i = 0; i < masses.size(); ++i) sum += moves(3 * i) ? g * masses[i] * at[3 * i + 1] : 0.0;
      return sum;
    };
  }
  /// Adds springs of this stiffness from every coordinate to 0; unless `is_round`, direction k has k + 1 times as much.
  void set_well(double stiffness, bool is_round = true) {
    const auto of = [=](std::size_t k) { return stiffness * (is_round ? 1.0 : 1.0 + static_cast<double>(k % 3)); };
    set_forces = [=](const std::vector<double>& at, std::vector<double>* forces) {
      for (std::size_t k = 0; k < at.size(); ++k) (*forces)[k] = -of(k) * at[k];
    };
    potential = [=](const std::vector<double>& at) {
      double sum = 0.0;
      for (std::size_t k = 0; k < at.size(); ++k) sum += 0.5 * of(k) * at[k] * at[k];
      return sum;
    };
  }
};

/// Returns rods from each point to the next.
inline Rods make_chain_of_rods(std::size_t num_points, Index first = 0) {
  Rods rods{"rods", {}, {}, {}};
  for (Index i = 1; i < static_cast<Index>(num_points); ++i) rods.pairs.push_back({first + i - 1, first + i});
  return rods;
}

/// Makes a chain of points of mass `mass`, `length` apart, from a support at the origin in direction (x, y).
inline Host make_hanging_chain(std::size_t num_rods, double length, double mass, double x, double y) {
  std::vector<double> masses(num_rods + 1, mass), r;
  masses[0] = infinity;
  for (std::size_t i = 0; i <= num_rods; ++i) {
    const double s = length * static_cast<double>(i);
    r.insert(r.end(), {s * x, s * y, 0.0});
  }
  return {masses, r, {make_chain_of_rods(num_rods + 1)}};
}

/// Returns rods for all distances among these points.
inline Rods make_all_distances(Index num_points) {
  Rods rods{"rods", {}, {}, {}};
  for (Index i = 0; i < num_points; ++i)
    for (Index j = i + 1; j < num_points; ++j) rods.pairs.push_back({i, j});
  return rods;
}

}  // namespace tanor::host
