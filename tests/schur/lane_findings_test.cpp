/// Compares the reports and the moves of solvers in lanes with K and M, row by row and island by island.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "schur/answers.hpp"
#include "schur/rod_rows.hpp"
#include "schur/solver_at_place.hpp"

namespace tanor {
namespace {

using Pairs = std::vector<std::array<Index, 2>>;

Pairs path_of(Index count) {
  Pairs result;
  for (Index k = 0; k < count; ++k) result.push_back({k, k + 1});
  return result;
}
Pairs ring_of(Index count) {
  Pairs result = path_of(count - 1);
  result.push_back({count - 1, 0});
  return result;
}
Pairs star_of(Index count) {
  Pairs result;
  for (Index k = 1; k <= count; ++k) result.push_back({0, k});
  return result;
}
Pairs tree_of(Index count, AnyNumbers* any) {
  Pairs result;
  for (Index k = 1; k <= count; ++k) result.push_back({std::max(0, k - 1 - any->up_to(std::min(k, 9) - 1)), k});
  return result;
}
std::vector<Pairs> copies_of(const Pairs& one, std::size_t count) {
  return std::vector<Pairs>(count, one);
}

/// Makes islands of rods with points at random places.
System make_islands(const std::vector<Pairs>& islands, AnyNumbers* any) {
  System system;
  Rods rods{"rods", {}, {}, {}};
  for (const Pairs& pairs : islands) {
    const auto first = static_cast<Index>(system.masses.size());
    Index count = 0;
    for (const auto& [i, j] : pairs) {
      count = std::max({count, i + 1, j + 1});
      rods.pairs.push_back({first + i, first + j});
    }
    for (Index k = 0; k < count; ++k) (void)add_point({3.0 * (*any)(), 3.0 * (*any)(), 3.0 * (*any)()}, any, &system);
  }
  system.constraints = {rods};
  return system;
}

struct Case {
  LinearSolver solver;
  std::vector<Pairs> islands;
};

std::vector<Case> cases(AnyNumbers* any) {
  const auto tree = [&](Index count) { return tree_of(count, any); };
  return {{LinearSolver::Paths, {path_of(3)}},
          {LinearSolver::Paths, {path_of(40)}},
          {LinearSolver::Paths, {ring_of(40)}},
          {LinearSolver::Paths, {path_of(3), path_of(40), path_of(5)}},
          {LinearSolver::Paths, {ring_of(20), ring_of(3), path_of(9), ring_of(40)}},
          {LinearSolver::Trees, {tree(40)}},
          {LinearSolver::Trees, {tree(300)}},
          {LinearSolver::Trees, {star_of(150)}},
          {LinearSolver::Trees, {tree(9), tree(30), tree(17), tree(30), tree(3), tree(12)}},
          {LinearSolver::Trees, {star_of(60), tree(40), tree(200)}},
          {LinearSolver::Batches, copies_of(ring_of(4), 11)}};
}

std::string name_of(const Case& each) {
  return std::to_string(static_cast<int>(each.solver)) + ": " + std::to_string(each.islands.size()) +
         " islands, the first of " + std::to_string(each.islands[0].size()) + " rods";
}

/// Many islands, which threads share.
std::vector<Case> cases_of_many(AnyNumbers* any) {
  return {{LinearSolver::Trees, copies_of(tree_of(31, any), 900)},
          {LinearSolver::Paths, copies_of(path_of(90), 400)},
          {LinearSolver::Batches, copies_of(ring_of(5), 6000)}};
}

/// The islands of a case with K and the factor of their places.
struct Factorized : SolverAtPlace {
  std::vector<double> blocks;

  Factorized(const System& system, LinearSolver kind, int threads = 1)
      : SolverAtPlace(system, kind, threads), blocks(3 * work.constraints.num_blocks()) {
    EXPECT_GT(solver.linearise(model.parallel, r.data(), nullptr, blocks.data()).reciprocal_condition, 0.0);
  }
  Factorized(const Case& each, AnyNumbers* any, int threads = 1)
      : Factorized(make_islands(each.islands, any), each.solver, threads) {}
};

/// Moving one point after the factor was made leaves a residual in the rows beside it alone.
TEST(LaneFindings, AKeptFactorTellsTheResidualOfEachIsland) {
  AnyNumbers any(61);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    Constraints& constraints = at.work.constraints;
    std::vector<double> b(model.num_rows()), scratch(b), lambda(b), w0(at.r.size());
    for (double& w : w0) w = 5.0 * any();
    for (std::size_t point = 0; point < model.num_moving(); point += 1 + model.num_moving() / 60) {
      std::vector<double> r = at.r, w = w0;
      for (std::size_t c = 0; c < 3; ++c) r[3 * point + c] += 0.1 * any();
      constraints.evaluate_gradients(model.parallel, r.data(), at.blocks.data());
      (void)constraints.evaluate_right_side(model.parallel, r.data(), at.v.data(), w.data(), b.data(), nullptr);
      std::vector<double> rest = b;
      const Elimination found = at.solver.solve(model.parallel, {r.data(), at.v.data(), w.data()}, FactorUse::Keep,
                                                at.blocks.data(), scratch.data(), lambda.data(), w.data());
      for (const Incidence& one : model.incidences) {
        const Vec3 dw = load(w.data(), one.point) - load(w0.data(), one.point);
        rest[static_cast<std::size_t>(one.row)] += one.sign * dot(load(at.blocks.data(), one.block), dw);
      }
      double own = 0.0;
      for (std::size_t island = 0; island < model.numbering.num_islands(); ++island) {
        const auto first = static_cast<std::size_t>(model.numbering.island_start[island]),
                   end = static_cast<std::size_t>(model.numbering.island_start[island + 1]);
        const auto of = [&](const std::vector<double>& rows) {
          return largest(std::span(rows).subspan(first, end - first));
        };
        own = std::max(own, of(rest) / of(b));
      }
      const double scale = largest(b);
      EXPECT_NEAR(found.residual, largest(rest), 1e-11 * scale) << point;
      EXPECT_NEAR(found.largest_right_side, scale, 1e-13 * scale) << point;
      EXPECT_NEAR(found.own_residual, own, 1e-10 * (1.0 + own)) << point;
    }
  }
}

/// Trees keep the directions of their factor; others act along the blocks that they are given.
TEST(LaneFindings, MultipliersActAlongTheBlocksThatAreGiven) {
  AnyNumbers any(62);
  for (const Case& each : cases(&any)) {
    if (each.solver == LinearSolver::Trees) continue;
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    std::vector<double> rows(model.num_rows());
    for (double& x : at.blocks) x *= 1.0 + 0.02 * any();
    const auto expect_along_blocks = [&](std::vector<double> before, const std::vector<double>& after,
                                         const std::vector<double>& multipliers) {
      model.gather.add_scaled(model.parallel, at.blocks.data(), multipliers.data(), model.inverse_mass.data(),
                              model.num_moving(), before.data());
      EXPECT_LE(largest_difference(before, after), 1e-12 * (1.0 + largest(after)));
    };
    std::vector<double> points(at.r.size());
    for (double& row : rows) row = any();
    at.solver.correct(model.parallel, at.blocks.data(), rows.data(), points.data());
    expect_along_blocks(std::vector<double>(points.size()), points, rows);

    // Each call comes after another one at the factor's own configuration.
    std::vector<double> own(at.blocks.size()), v = at.v, r = at.r, sum(rows.size());
    (void)at.solver.linearise(model.parallel, at.r.data(), nullptr, own.data());
    (void)at.solver.project_velocities(model.parallel, at.blocks.data(), 1e-12, at.r.data(), v.data(), sum.data());
    expect_along_blocks(at.v, v, sum);
    (void)at.solver.linearise(model.parallel, at.r.data(), nullptr, own.data());
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) r[i] += 1e-3 * any();
    const std::vector<double> before = r;
    (void)at.solver.project_positions(model.parallel, at.blocks.data(), 1e-12, r.data(), nullptr, nullptr);
    std::vector<double> guided = before;
    std::ranges::fill(sum, 0.0);
    (void)at.solver.linearise(model.parallel, at.r.data(), nullptr, own.data());
    (void)at.solver.project_positions(model.parallel, at.blocks.data(), 1e-12, guided.data(), nullptr, sum.data());
    expect_along_blocks(before, guided, sum);
    EXPECT_LE(largest_difference(r, guided), 1e-12 * largest(r));
  }
}

TEST(LaneFindings, AGuessOfMultipliersMovesPoints) {
  AnyNumbers any(63);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    std::vector<double> sum(model.num_rows()), r = at.r;
    for (double& row : sum) row = 1e-3 * any();
    const std::vector<double> guess = sum;
    const Projection none =
        at.solver.project_positions(model.parallel, at.blocks.data(), HUGE_VAL, r.data(), nullptr, sum.data());
    EXPECT_EQ(none.iterations, 0);
    EXPECT_EQ(sum, guess);
    std::vector<double> moved = at.r;
    model.gather.add_scaled(model.parallel, at.blocks.data(), guess.data(), model.inverse_mass.data(),
                            model.num_moving(), moved.data());
    EXPECT_LE(largest_difference(moved, r), 1e-13 * largest(r));
    EXPECT_GT(largest_difference(at.r, r), 1e-5);
  }
}

/// All pieces of a star end at one point, one after the other.
TEST(LaneFindings, StarsAreProjectedAlongTheirGradients) {
  AnyNumbers any(64);
  expect_projections_along_gradients(make_islands({star_of(150)}, &any), LinearSolver::Trees);
}

/// Threads take islands by themselves; the report is that of all.
TEST(LaneFindings, TheWorstIslandOfAnyThreadIsReported) {
  AnyNumbers any(65);
  for (const Case& each : cases_of_many(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any, 3);
    const Model& model = at.model;
    for (const std::size_t point : {std::size_t{0}, model.num_moving() / 2, model.num_moving() - 1}) {
      std::vector<double> r = at.r;
      r[3 * point] += 1e-3;
      const double known = at.work.constraints.evaluate_values(model.parallel, r.data(), at.there.data());
      const Projection none =
          at.solver.project_positions(model.parallel, at.blocks.data(), 1.0, r.data(), nullptr, nullptr);
      EXPECT_GT(known, 1e-5);
      EXPECT_NEAR(none.violation, known, 1e-9 * known) << point;
    }
  }
}

/// A light point between two heavy ones, in a line, makes two rows nearly dependent, in whatever order they are
/// eliminated.
TEST(LaneFindings, TwoRowsThatAreNearlyDependentShowInTheCondition) {
  AnyNumbers any(66);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    const System system = make_islands(each.islands, &any);
    const auto num_points = static_cast<Index>(system.masses.size());
    for (Index point = 0; point < num_points; point += 1 + num_points / 50) {
      System light = system;
      std::vector<Index> beside;
      for (const auto& [i, j] : std::get<Rods>(light.constraints[0]).pairs) {
        if (i == point || j == point) beside.push_back(i == point ? j : i);
      }
      if (beside.size() < 2) continue;
      light.masses[static_cast<std::size_t>(point)] = 1e-7;
      for (std::size_t c = 0; c < 3; ++c) {
        const auto at = [&](Index i) -> double& { return light.positions[3 * static_cast<std::size_t>(i) + c]; };
        at(point) = 0.5 * (at(beside[0]) + at(beside[1]));
      }
      SolverAtPlace at(light, each.solver);
      std::vector<double> blocks(3 * at.work.constraints.num_blocks());
      const double condition =
          at.solver.linearise(at.model.parallel, at.r.data(), nullptr, blocks.data()).reciprocal_condition;
      EXPECT_LE(condition, 1e-5) << point;
    }
  }
}

/// Rods of nobody, which fill the lanes of shorter pieces, have no share in the condition.
TEST(LaneFindings, TheConditionDoesNotDependOnTheUnitOfMass) {
  AnyNumbers any(67);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    System system = make_islands(each.islands, &any);
    const auto condition_of = [&] {
      SolverAtPlace at(system, each.solver);
      std::vector<double> blocks(3 * at.work.constraints.num_blocks());
      return at.solver.linearise(at.model.parallel, at.r.data(), nullptr, blocks.data()).reciprocal_condition;
    };
    const double condition = condition_of();
    for (const double unit : {0x1p-30, 0x1p60}) {
      for (double& mass : system.masses) mass *= unit;
      EXPECT_EQ(condition_of(), condition) << unit;
    }
  }
}

TEST(LaneFindings, ANumberThatIsNoneIsForgotten) {
  AnyNumbers any(68);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    SolverAtPlace at(make_islands(each.islands, &any), each.solver);
    const Model& model = at.model;
    const auto solve_at = [&](const std::vector<double>& r) {
      std::vector<double> blocks(3 * at.work.constraints.num_blocks()), scratch(model.num_rows()), lambda(scratch),
          w(r.size());
      const Elimination found = at.solver.solve(model.parallel, {r.data(), at.v.data(), w.data()}, FactorUse::Renew,
                                                blocks.data(), scratch.data(), lambda.data(), w.data());
      return std::pair(std::vector{found.reciprocal_condition, found.residual, found.own_residual}, lambda);
    };
    const auto good = solve_at(at.r);
    for (std::size_t point = 0; point < model.num_moving(); point += 1 + model.num_moving() / 20) {
      std::vector<double> bad = at.r;
      bad[3 * point] = std::numeric_limits<double>::quiet_NaN();
      (void)solve_at(bad);
      EXPECT_EQ(solve_at(at.r), good) << point;
    }
  }
}

TEST(LaneFindings, ASingleRowIsCorrected) {
  AnyNumbers any(69);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    for (std::size_t row = 0; row < model.num_rows(); row += 1 + model.num_rows() / 50) {
      std::vector<double> rows(model.num_rows()), x(rows), points(at.r.size()), moved(points);
      rows[row] = 1.0;
      at.solver.solve_negative(model.parallel, rows.data(), x.data());
      at.solver.correct(model.parallel, at.blocks.data(), rows.data(), points.data());
      EXPECT_LE(relative_difference(rows, x), 1e-13) << row;
      model.gather.add_scaled(model.parallel, at.blocks.data(), x.data(), model.inverse_mass.data(), model.num_moving(),
                              moved.data());
      EXPECT_LE(relative_difference(points, moved), 1e-12) << row;
    }
  }
}

/// The chord keeps the directions of the factor, but the violation is that at the place which is given.
TEST(LaneFindings, VelocitiesAreProjectedAtTheirOwnPlace) {
  AnyNumbers any(70);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    std::vector<double> v = at.v, r = at.r;
    for (double& x : r) x += 0.1 * any();
    const double known = at.work.constraints.evaluate_rates(model.parallel, r.data(), v.data(), at.there.data());
    const Projection none =
        at.solver.project_velocities(model.parallel, at.blocks.data(), HUGE_VAL, r.data(), v.data(), nullptr);
    EXPECT_NEAR(none.violation, known, 1e-12 * known);
  }
}

TEST(LaneFindings, MultipliersOfVelocitiesAreAddedToTheirSum) {
  AnyNumbers any(71);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    Factorized at(each, &any);
    const Model& model = at.model;
    std::vector<double> v = at.v, sum(model.num_rows()), more(sum);
    (void)at.solver.project_velocities(model.parallel, at.blocks.data(), 1e-12, at.r.data(), v.data(), sum.data());
    for (std::size_t row = 0; row < sum.size(); ++row) sum[row] += more[row] = 1.0 + std::abs(any());
    std::vector<double> again = at.v;
    (void)at.solver.project_velocities(model.parallel, at.blocks.data(), 1e-12, at.r.data(), again.data(), more.data());
    EXPECT_EQ(again, v);
    EXPECT_LE(relative_difference(more, sum), 1e-14);
  }
}

TEST(LaneFindings, IterationsAreThoseOfTheWorstIsland) {
  AnyNumbers any(72);
  for (const Case& each : cases_of_many(&any)) {
    SCOPED_TRACE(name_of(each));
    const System system = make_islands(each.islands, &any);
    for (const bool is_first : {true, false}) {
      std::vector<int> iterations;
      for (const int threads : {1, 3}) {
        SolverAtPlace at(system, each.solver, threads);
        const Model& model = at.model;
        std::vector<double> blocks(3 * at.work.constraints.num_blocks()), r = at.r;
        (void)at.solver.linearise(model.parallel, at.r.data(), nullptr, blocks.data());
        r[is_first ? 0 : 3 * (model.num_moving() - 1)] += 1e-4;
        iterations.push_back(
            at.solver.project_positions(model.parallel, blocks.data(), 1e-12, r.data(), nullptr, nullptr).iterations);
      }
      EXPECT_GT(iterations[0], 0);
      EXPECT_EQ(iterations[1], iterations[0]);
    }
  }
}

TEST(LaneFindings, NothingIsLeftOfAnEarlierFactor) {
  AnyNumbers any(73);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    const System system = make_islands(each.islands, &any);
    SolverAtPlace at(system, each.solver), other(system, each.solver);
    const Model& model = at.model;
    std::vector<double> blocks(3 * at.work.constraints.num_blocks()), r = at.r, b(model.num_rows()), x(b), known(b);
    (void)at.solver.linearise(model.parallel, at.r.data(), nullptr, blocks.data());
    for (double& place : r) place += 0.1 * any();
    for (double& row : b) row = any();
    const Elimination made = other.solver.linearise(model.parallel, r.data(), nullptr, blocks.data()),
                      given = at.solver.linearise(model.parallel, r.data(), nullptr, blocks.data());
    EXPECT_EQ(given.reciprocal_condition, made.reciprocal_condition);
    at.solver.solve_negative(model.parallel, b.data(), x.data());
    other.solver.solve_negative(model.parallel, b.data(), known.data());
    EXPECT_EQ(x, known);
  }
}

/// A rod has its offset from its first point to its second one, whichever comes first in the lanes.
TEST(LaneFindings, OffsetsAreReadAgain) {
  AnyNumbers any(74);
  for (const Case& each : cases(&any)) {
    SCOPED_TRACE(name_of(each));
    System system = make_islands(each.islands, &any);
    auto& rods = std::get<Rods>(system.constraints[0]);
    for (auto& [i, j] : rods.pairs) {
      if (any.up_to(1) == 0) std::swap(i, j);
      rods.offsets.push_back({any(), any(), any()});
    }
    SolverAtPlace at(system, each.solver);
    for (Vector3& offset : rods.offsets) offset = {any(), any(), any()};
    SolverAtPlace other(system, each.solver);
    const RodRows rows(other.work.constraints, other.model.num_rows());
    at.solver.read_offsets(rows.offset);
    std::vector<double> blocks(3 * at.work.constraints.num_blocks()), known(blocks);
    (void)at.solver.linearise(at.model.parallel, at.r.data(), nullptr, blocks.data());
    (void)other.solver.linearise(at.model.parallel, at.r.data(), nullptr, known.data());
    EXPECT_EQ(blocks, known);
  }
}

}  // namespace
}  // namespace tanor
