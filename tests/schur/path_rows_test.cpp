/// Paths of rods evaluate their own rows as the families of constraints do.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "schur/solver_at_place.hpp"

namespace tanor {
namespace {

enum class Kind { Plain, Shifted, Timed };

/// Makes paths of rods, points and rods numbered at random; some are held at their ends, some closed to rings.
System make_paths(const std::vector<std::size_t>& lengths, Kind kind, std::mt19937* random) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto number = [&] { return unit(*random); };
  const std::size_t num_points = std::accumulate(lengths.begin(), lengths.end(), lengths.size());
  std::vector<Index> place(num_points);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), *random);
  System system;
  system.positions.resize(3 * num_points);
  system.velocities.resize(3 * num_points);
  for (std::size_t i = 0; i < num_points; ++i) system.masses.push_back(std::exp(number()));
  Rods rods;
  std::size_t next = 0;
  for (const std::size_t length : lengths) {
    Vec3 at{number(), number(), number()};
    for (std::size_t k = 0; k <= length; ++k, ++next) {
      store(system.positions.data(), place[next], at);
      store(system.velocities.data(), place[next], {number(), number(), number()});
      at = at + Vec3{0.5 + 0.2 * number(), 0.4 * number(), 0.4 * number()};
      if (k == 0) continue;
      const std::size_t turned = number() > 0.0 ? 1 : 0;
      rods.pairs.push_back({place[next - turned], place[next - 1 + turned]});
      if (kind == Kind::Shifted) rods.offsets.push_back({0.1 * number(), 0.1 * number(), 0.1 * number()});
    }
    const bool is_ring = length > 2 && number() > 0.3;
    if (is_ring) {
      rods.pairs.push_back({place[next - 1], place[next - 1 - length]});
      if (kind == Kind::Shifted) rods.offsets.push_back({0.1 * number(), 0.1 * number(), 0.1 * number()});
    }
    for (const std::size_t end : {next - length - 1, next - 1}) {
      if (!is_ring && length > 1 && number() > 0.0)
        system.supports.push_back({"", {place[end]}, VectorFunction(0.0, 0.0, 0.0)});
    }
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), *random);
  for (std::size_t k = 0; kind == Kind::Timed && k < rods.pairs.size(); ++k) {
    // The rod has its initial length at t = 0.3.
    const auto& [i, j] = rods.pairs[k];
    const double length = norm(load(system.positions.data(), j) - load(system.positions.data(), i));
    rods.length.functions.push_back(ScalarFunction::formula(std::to_string(length) + " + 0.1*sin(3*t - 0.9)"));
  }
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

struct Rows : SolverAtPlace {
  explicit Rows(const System& system, int threads = 1) : SolverAtPlace(system, LinearSolver::Paths, threads) {}
};

const std::vector<std::vector<std::size_t>> shapes = {{1},      {2},           {3, 1, 2},          {127}, {128}, {129},
                                                      {130, 5}, {255, 9, 257}, {10, 10, 10, 1000}, {7000}};
constexpr double row_rounding = 1e-14;

class PathRows : public testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, PathRows, testing::Values(Kind::Plain, Kind::Shifted, Kind::Timed));

TEST_P(PathRows, SolvingWithAKeptFactorGivesTheSameNumbers) {
  std::mt19937 random(32);
  for (const auto& lengths : shapes) {
    Rows rows(make_paths(lengths, GetParam(), &random));
    Workspace& work = rows.work;
    const Model& model = rows.model;
    std::vector<double> blocks(3 * work.constraints.num_blocks()), again_blocks(blocks), b(model.num_rows());
    std::vector<double> lambda(b), again(b), w(rows.r.size()), w_again(w);
    for (std::vector<double>* array : {&w, &w_again})
      (void)work.evaluate_free(0.3, rows.r.data(), rows.v.data(), array->data());

    const Elimination solved = rows.solver.solve(model.parallel, {rows.r.data(), rows.v.data(), w.data()},
                                                 FactorUse::Renew, blocks.data(), b.data(), lambda.data(), w.data());
    const Elimination linearised = rows.solver.linearise(model.parallel, rows.r.data(), nullptr, again_blocks.data());
    const Elimination found =
        rows.solver.solve(model.parallel, {rows.r.data(), rows.v.data(), w_again.data()}, FactorUse::Keep,
                          again_blocks.data(), b.data(), again.data(), w_again.data());

    ASSERT_GT(solved.reciprocal_condition, 0.0);
    EXPECT_LE(largest_difference(blocks, again_blocks), row_rounding);
    EXPECT_NEAR(linearised.reciprocal_condition / solved.reciprocal_condition, 1.0, 1e-10);
    EXPECT_NEAR(found.largest_right_side / solved.largest_right_side, 1.0, row_rounding);
    EXPECT_LE(found.residual, 1e-11 * found.largest_right_side);
    EXPECT_LE(relative_difference(again, lambda), 1e-12);
    EXPECT_LE(relative_difference(w_again, w), 1e-12);
  }
}

TEST(PathRows, AnyNumberOfThreadsFindsTheSameBits) {
  std::mt19937 random(33);
  const System system = make_paths({20000, 3, 4000, 9001, 4096, 700}, Kind::Plain, &random);
  std::vector<std::vector<double>> found;
  for (const int threads : {1, 2, 3, 5}) {
    Rows rows(system, threads);
    const Model& model = rows.model;
    std::vector<double> blocks(3 * rows.work.constraints.num_blocks()), b(model.num_rows()), lambda(b),
        w(rows.r.size());
    std::vector<double>& all = found.emplace_back();
    const auto append = [&](const std::vector<double>& x) { all.insert(all.end(), x.begin(), x.end()); };
    (void)rows.solver.linearise(model.parallel, rows.r.data(), nullptr, blocks.data());
    const Elimination again = rows.solver.solve(model.parallel, {rows.r.data(), rows.v.data(), w.data()},
                                                FactorUse::Keep, blocks.data(), b.data(), lambda.data(), w.data());
    append({again.largest_right_side, again.residual});
    append(b);
    append(lambda);
    append(w);
    // Every other call, with points from elsewhere where there may be some.
    std::vector<double> given = rows.r, r = given, v = rows.v, sum = lambda;
    for (std::size_t i = 0; i < 3 * model.num_moving(); ++i) {
      given[i] += 1e-5 * std::sin(static_cast<double>(i));
      r[i] = std::nan("");
    }
    const CopiedPoints source(given, &r);
    for (double& each : sum) each *= 1e-9;
    const Projection at =
        rows.solver.project_positions(model.parallel, blocks.data(), 1e-13, r.data(), &source, sum.data());
    EXPECT_LE(at.violation, 1e-11);  // the ends are some 1e4 lengths away, where places round to 2e-12
    append(r);
    append(sum);
    (void)rows.solver.project_velocities(model.parallel, blocks.data(), 1e-13, r.data(), v.data(), sum.data());
    append(v);
    append(sum);
    rows.solver.correct(model.parallel, blocks.data(), b.data(), w.data());
    rows.solver.add_reactions(model.parallel, blocks.data(), lambda.data(), w.data());
    append(b);
    append(w);
  }
  for (const std::vector<double>& each : found) EXPECT_TRUE(each == found.front());
}

TEST_P(PathRows, ManyPathsAreProjectedAlongTheirGradients) {
  std::mt19937 random(34);
  const System system = make_paths({1, 2, 3, 127, 128, 129, 130, 257, 10, 700, 5, 4}, GetParam(), &random);
  expect_projections_along_gradients(system, LinearSolver::Paths);
}

TEST_P(PathRows, FewPathsAreProjectedAlongTheirGradients) {
  std::mt19937 random(37);
  for (const std::vector<std::size_t>& lengths : {std::vector<std::size_t>{9}, {300, 7}, {3, 1000}}) {
    const System system = make_paths(lengths, GetParam(), &random);
    expect_projections_along_gradients(system, LinearSolver::Paths);
  }
}

TEST(PathRows, PointsThatCoincideMakeNoFactor) {
  std::mt19937 random(35);
  const System system = make_paths({300}, Kind::Plain, &random);
  for (const std::size_t row : {0, 1, 77, 149, 150, 151, 299}) {
    Rows rows(system);
    std::vector<double> blocks(3 * rows.work.constraints.num_blocks());
    // Rows and points are counted along the path in the inner order.
    for (std::size_t c = 0; c < 3; ++c) rows.r[3 * row + c] = rows.r[3 * (row + 1) + c];
    const double condition =
        rows.solver.linearise(rows.model.parallel, rows.r.data(), nullptr, blocks.data()).reciprocal_condition;
    EXPECT_FALSE(condition > 0.0) << row;
  }
}

TEST(PathRows, APlaceThatIsNotANumberShowsInTheLargestViolation) {
  std::mt19937 random(34);
  const System system = make_paths({300}, Kind::Plain, &random);
  for (const std::size_t point : {0, 1, 77, 299, 300}) {
    Rows rows(system);
    const Parallel& parallel = rows.model.parallel;
    std::vector<double> blocks(3 * rows.work.constraints.num_blocks());
    (void)rows.solver.linearise(parallel, rows.r.data(), nullptr, blocks.data());
    rows.r[3 * point + 1] = std::nan("");
    const double* const b = blocks.data();
    EXPECT_TRUE(std::isnan(
        rows.solver.project_velocities(parallel, b, 1e-12, rows.r.data(), rows.v.data(), nullptr).violation));
    EXPECT_TRUE(
        std::isnan(rows.solver.project_positions(parallel, b, 1e-12, rows.r.data(), nullptr, nullptr).violation));
  }
}

}  // namespace
}  // namespace tanor
