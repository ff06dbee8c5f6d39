#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "ranks/thread_ranks.hpp"

/// \file A system on several ranks is compared with the same system on one.
namespace tanor {

/// Assigns the points to ranks along an axis, in pieces of equal length.
inline std::vector<int> cut_along(const System& system, std::size_t axis, int num_ranks) {
  std::vector<double> x;
  for (std::size_t i = 0; i < system.num_points(); ++i) x.push_back(system.positions[3 * i + axis]);
  const auto [low, high] = std::ranges::minmax(x);
  std::vector<int> owner;
  for (const double each : x)
    owner.push_back(std::min(num_ranks - 1, static_cast<int>(num_ranks * (each - low) / (high - low) + 1e-9)));
  return owner;
}

/// The end of a simulation, for all points and equations.
struct Ending {
  std::vector<double> positions, velocities, accelerations, multipliers, reactions;
  MotionReport report;
  RankReport rank;
  Outcome outcome;
};

inline SolverOptions one_thread() {
  SolverOptions solver;
  solver.threads = 1;
  return solver;
}

inline Ending run_whole(const System& system, const MotionOptions& options, double t_end) {
  Simulation simulation(system, options, one_thread());
  if (t_end > 0.0) (void)simulation.advance_to(t_end);
  const auto copy = [](std::span<const double> array) { return std::vector<double>(array.begin(), array.end()); };
  return {copy(simulation.positions()),
          copy(simulation.velocities()),
          copy(simulation.accelerations()),
          copy(simulation.multipliers()),
          copy(simulation.reactions()),
          simulation.report(),
          simulation.rank(),
          simulation.outcome()};
}

/// Runs the same simulation on ranks; every rank writes what it owns.
inline Ending run_on_ranks(const System& system, const std::vector<int>& owner, int num_ranks,
                           const MotionOptions& options, double t_end) {
  Ending ending;
  for (std::vector<double>* array : {&ending.positions, &ending.velocities, &ending.accelerations, &ending.reactions})
    array->resize(3 * system.num_points());
  ending.multipliers.resize(num_equations(system));
  std::vector<MotionReport> reports(static_cast<std::size_t>(num_ranks));
  std::vector<Outcome> outcomes(static_cast<std::size_t>(num_ranks));
  ThreadWorld(num_ranks).run([&](Ranks& ranks) {
    const RankSystem own = take_part(system, owner, ranks);
    Simulation simulation(own.system, own.part, options, one_thread());
    if (t_end > 0.0) (void)simulation.advance_to(t_end);
    const std::size_t num_written = ranks.rank() == 0 ? own.points.size() - own.part.guests.size() : own.num_owned;
    const auto write = [&](std::span<const double> from, std::vector<double>* to) {
      for (std::size_t i = 0; i < num_written; ++i)
        std::copy_n(from.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                    to->begin() + 3 * static_cast<std::ptrdiff_t>(own.points[i]));
    };
    write(simulation.positions(), &ending.positions);
    write(simulation.velocities(), &ending.velocities);
    write(simulation.accelerations(), &ending.accelerations);
    write(simulation.reactions(), &ending.reactions);
    std::vector<char> is_elsewhere(own.equations.size(), 0);
    for (const Part::SharedRow& row : own.part.shared_rows) is_elsewhere[row.equation] = row.is_counted ? 0 : 1;
    for (std::size_t a = 0; a < own.equations.size(); ++a)
      if (is_elsewhere[a] == 0) ending.multipliers[own.equations[a]] = simulation.multipliers()[a];
    const RankReport rank = simulation.rank();
    if (ranks.rank() == num_ranks - 1) ending.rank = rank;
    reports[static_cast<std::size_t>(ranks.rank())] = simulation.report();
    outcomes[static_cast<std::size_t>(ranks.rank())] = simulation.outcome();
  });
  for (int rank = 1; rank < num_ranks; ++rank) {
    const MotionReport& own = reports[static_cast<std::size_t>(rank)];
    EXPECT_EQ(own.steps, reports[0].steps);
    EXPECT_EQ(own.rejected, reports[0].rejected);
    EXPECT_EQ(own.time, reports[0].time);
    EXPECT_EQ(own.energy.now, reports[0].energy.now);
    EXPECT_EQ(own.accuracy_warning, reports[0].accuracy_warning);
    EXPECT_EQ(outcomes[static_cast<std::size_t>(rank)].what, outcomes[0].what);
  }
  ending.report = reports[0];
  ending.outcome = outcomes[0];
  return ending;
}

inline double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0, error = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    largest = std::max(largest, std::abs(b[k]));
    error = std::max(error, std::abs(a[k] - b[k]));
  }
  return error / (largest > 0.0 ? largest : 1.0);
}

inline MotionOptions options_of(Method method, double step = 0.0) {
  MotionOptions options;
  options.method = method;
  options.step = step;
  options.rtol = 1e-9;
  return options;
}

/// Deals points to owners in turn, so that every rod and spring of a chain reaches from rank to rank.
inline std::vector<int> deal(const System& system, int num_ranks) {
  std::vector<int> owner(system.num_points());
  for (std::size_t i = 0; i < owner.size(); ++i) owner[i] = static_cast<int>(i) % num_ranks;
  return owner;
}

/// Gives the last point to one of two ranks, all others to the other one.
inline std::vector<int> part_the_last(const System& system, int rank) {
  std::vector<int> owner(system.num_points(), 1 - rank);
  owner.back() = rank;
  return owner;
}

/// Expects the same steps, and the same state and energies at the end.
inline void expect_same_ending(const Ending& many, const Ending& one, double allowed) {
  ASSERT_TRUE(many.outcome.ok()) << many.outcome.what;
  EXPECT_EQ(many.report.method, one.report.method);
  EXPECT_EQ(many.report.steps, one.report.steps);
  EXPECT_EQ(many.report.rejected, one.report.rejected);
  EXPECT_EQ(many.rank.is_known, one.rank.is_known);
  EXPECT_EQ(many.rank.rank, one.rank.rank);
  EXPECT_EQ(many.rank.degrees_of_freedom, one.rank.degrees_of_freedom);
  EXPECT_LE(difference(many.positions, one.positions), allowed);
  EXPECT_LE(difference(many.velocities, one.velocities), allowed);
  EXPECT_LE(difference(many.accelerations, one.accelerations), 10.0 * allowed);
  const EnergyReport &a = one.report.energy, &b = many.report.energy;
  EXPECT_NEAR(b.scale, a.scale, allowed * a.scale);
  EXPECT_NEAR(b.now, a.now, allowed * a.scale);
  EXPECT_NEAR(b.work_of_supports, a.work_of_supports, allowed * a.scale);
  EXPECT_NEAR(b.work_of_forces, a.work_of_forces, allowed * a.scale);
  EXPECT_NEAR(b.work_of_potentials, a.work_of_potentials, allowed * a.scale);
}

/// Expects the same motion, however the points are given to ranks.
inline void expect_same_motion(const System& system, const MotionOptions& options, double t_end, double allowed) {
  const Ending one = run_whole(system, options, t_end);
  ASSERT_TRUE(one.outcome.ok()) << one.outcome.what;
  for (const auto& [owner, num_ranks] :
       {std::pair(cut_along(system, 0, 2), 2), std::pair(cut_along(system, 0, 4), 4), std::pair(deal(system, 3), 3)}) {
    SCOPED_TRACE(num_ranks);
    expect_same_ending(run_on_ranks(system, owner, num_ranks, options, t_end), one, allowed);
  }
}

}  // namespace tanor
