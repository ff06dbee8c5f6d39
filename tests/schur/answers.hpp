#pragma once

/// \file The answers of two solvers for the same accelerations are compared.

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include <tanor/tanor.hpp>

#include "measures.hpp"

namespace tanor {

/// Relative difference that the answers of two solvers may have.
inline constexpr double rounding = 1e-12;

struct Answer {
  SolveReport report;
  std::vector<double> w, lambda, eta;
};

/// Returns the state at which `solve` solves.
inline StateView state_of(const System& system, double t = 0.0) {
  return {.time = t, .positions = system.positions, .velocities = system.velocities};
}

inline Answer solve(Dynamics* dynamics, const System& system, double t = 0.0) {
  Answer answer{{},
                std::vector<double>(system.positions.size()),
                std::vector<double>(dynamics->num_equations()),
                std::vector<double>(system.positions.size())};
  answer.report = dynamics->solve(state_of(system, t),
                                  {.accelerations = answer.w, .multipliers = answer.lambda, .reactions = answer.eta});
  return answer;
}

inline Answer solve(const System& system, const SolverOptions& options, double t = 0.0) {
  Dynamics dynamics(system, options);
  return solve(&dynamics, system, t);
}

/// Expects the same bits of an answer for any number of threads.
inline void expect_the_same_bits_with_threads(const System& system, LinearSolver solver) {
  const Answer one = solve(system, {.linear_solver = solver, .threads = 1});
  for (const int threads : {2, 3, 7}) {
    const Answer several = solve(system, {.linear_solver = solver, .threads = threads});
    EXPECT_EQ(several.w, one.w) << threads;
    EXPECT_EQ(several.lambda, one.lambda) << threads;
    EXPECT_EQ(several.report.residual, one.report.residual) << threads;
  }
}

/// Makes a ring of four rods that is stretched to a line, so that the rods depend on one another.
inline System make_stretched_ring() {
  System system;
  system.positions = {0, 0, 0, 1, 0, 0, 2, 0, 0, 1, 1e-9, 0};
  system.velocities.assign(12, 0.0);
  system.masses.assign(4, 1.0);
  system.constraints = {Rods{"ring", {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, {}, {}}};
  system.forces = {Gravity{"", {0, 0, -9.81}}};
  return system;
}

/// Random numbers in (-1, 1) with a fixed seed.
class AnyNumbers {
 public:
  explicit AnyNumbers(unsigned seed) : generator_(seed) {}
  double operator()() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator_); }
  int up_to(int most) { return std::uniform_int_distribution<int>(0, most)(generator_); }
  std::mt19937& generator() { return generator_; }

 private:
  std::mt19937 generator_;
};

inline Index add_point(const Vector3& place, AnyNumbers* any, System* system) {
  for (const double x : place) {
    system->positions.push_back(x);
    system->velocities.push_back((*any)());
  }
  system->masses.push_back(std::exp(2.0 * (*any)()));
  return static_cast<Index>(system->masses.size() - 1);
}

/// Adds points on planes and on lines of their own, and as many free ones.
inline void add_beads(int count, AnyNumbers* any, System* system) {
  Planes planes{"planes", {}, Vector3{0.1, 0.2, 1.0}, Parameter{}};
  Lines lines{"lines", {}, Vector3{0.0, 0.1, 0.2}, Vector3{1.0, 0.3, 0.0}};
  for (int k = 0; k < count; ++k) {
    planes.points.push_back(add_point({(*any)(), (*any)(), (*any)()}, any, system));
    lines.points.push_back(add_point({(*any)(), (*any)(), (*any)()}, any, system));
    add_point({(*any)(), (*any)(), (*any)()}, any, system);  // free
  }
  system->constraints.emplace_back(planes);
  system->constraints.emplace_back(lines);
}

}  // namespace tanor
