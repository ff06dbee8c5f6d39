/// Solvers that serve some islands of a system leave the rows and points of the others alone.

#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "beside.hpp"
#include "linearised.hpp"
#include "schur/lane_solver.hpp"
#include "schur/point_solver.hpp"
#include "schur/sparse_solver.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Makes `count` copies of rods that join `num_points` points at random positions.
System copies_of(int count, Index num_points, const std::vector<std::array<Index, 2>>& rods, std::mt19937* generator) {
  std::normal_distribution<double> normal;
  System system;
  Rods group;
  for (int copy = 0; copy < count; ++copy) {
    const auto first = static_cast<Index>(system.masses.size());
    for (Index k = 0; k < num_points; ++k) system.masses.push_back(std::exp(normal(*generator)));
    for (const auto& [i, j] : rods) group.pairs.push_back({first + i, first + j});
  }
  for (std::size_t i = 0; i < 3 * system.masses.size(); ++i) {
    system.positions.push_back(normal(*generator));
    system.velocities.push_back(normal(*generator));
  }
  system.constraints = {group};
  return system;
}

/// Makes islands of each kind, each kind twice and others between.
System islands_of_every_kind() {
  std::mt19937 generator(5);
  std::vector<std::array<Index, 2>> path;
  for (Index i = 0; i < 40; ++i) path.push_back({i, i + 1});
  System system;
  for (int k = 0; k < 2; ++k) {
    System beads = copies_of(9, 1, {}, &generator);
    beads.constraints = {Planes{"", {0, 1, 2, 3, 4, 5, 6, 7, 8}, Vector3{0.0, 0.2, 1.0}, Parameter{}},
                         Lines{"", {0}, Vector3{0.0, 0.0, 1.0}, Vector3{1.0, 0.1, 0.0}}};
    put_beside(beads, &system);
    put_beside(copies_of(10, 4, {{0, 1}, {1, 2}, {2, 3}}, &generator), &system);
    put_beside(copies_of(1, 41, path, &generator), &system);
    // The star has nine arms of three rods, of which eight have lanes, and a tail that a support holds.
    std::vector<std::array<Index, 2>> arms{{0, 28}, {28, 29}};
    for (Index arm = 0; arm < 9; ++arm) {
      for (Index m = 1; m <= 3; ++m) arms.push_back({m == 1 ? 0 : 3 * arm + m - 1, 3 * arm + m});
    }
    System tree = copies_of(1, 30, arms, &generator);
    tree.supports.push_back({"", {29}, {}});
    put_beside(tree, &system);
    System bent = copies_of(1, 5, {{0, 1}, {1, 2}, {2, 3}, {3, 4}}, &generator);
    bent.constraints.emplace_back(Angles{"", {{0, 1, 2}, {2, 3, 4}}, {}});
    bent.constraints.emplace_back(Linears{"", {{0, 4}}, {{1.0, 0.3, 0.2}, {0.1, -1.0, 0.2}}, {}});
    put_beside(bent, &system);
  }
  return system;
}

class PartsOfMixtures : public testing::TestWithParam<std::string> {
 protected:
  PartsOfMixtures()
      : system_(islands_of_every_kind()),
        inner_(system_, 0.0, system_.positions, system_.velocities),
        gather_(inner_.incidences, inner_.numbering.num_points()),
        left_(inner_.numbering.num_islands()) {
    std::iota(left_.begin(), left_.end(), 0);
  }

  /// Makes the part and writes its islands into `own`.
  std::unique_ptr<SchurSolver> make_part(std::vector<Index>* own) {
    const SchurProblem problem = this->problem();
    std::unique_ptr<SchurSolver> part;
    std::vector<Index> before;
    const auto take = [&](const std::string& name, const auto& make) {
      before = left_;
      std::unique_ptr<SchurSolver> solver = make();
      if (GetParam() != name) return;
      part = std::move(solver);
      std::ranges::set_difference(before, left_, std::back_inserter(*own));
    };
    take("points", [&] { return PointSolver::make(problem, &left_); });
    take("batches", [&] { return LaneSolver::make(problem, LinearSolver::Batches, 1, false, &left_); });
    take("paths", [&] { return LaneSolver::make(problem, LinearSolver::Paths, 1, false, &left_); });
    take("trees", [&] { return LaneSolver::make(problem, LinearSolver::Trees, 1, true, &left_); });
    if (part == nullptr) {
      *own = left_;
      part = std::make_unique<SparseSolver>(problem, IslandGroup(problem, *own));
    }
    return part;
  }

  SchurProblem problem() const {
    return {inner_.constraints, gather_, inner_.incidences, inner_.numbering, inner_.inverse_masses, system_.positions};
  }

  System system_;
  Linearised inner_;
  ReactionGather gather_;
  std::vector<Index> left_;
};

TEST_P(PartsOfMixtures, LeaveOthersRowsAndPointsAlone) {
  std::vector<Index> own;
  const std::unique_ptr<SchurSolver> part = make_part(&own);
  ASSERT_FALSE(own.empty());
  ASSERT_LT(own.size(), inner_.numbering.num_islands());
  const IslandGroup theirs(problem(), own);
  const std::size_t d = inner_.constraints.num_rows(), size = inner_.r.size();
  std::vector<char> is_own_block(inner_.constraints.num_blocks(), 0);
  for (const Incidence& incidence : inner_.incidences)
    if (theirs.rows.contains(static_cast<std::size_t>(incidence.row)))
      is_own_block[static_cast<std::size_t>(incidence.block)] = 1;
  const auto of_points = [&](const std::vector<double>& from) {
    std::vector<double> result = from;
    for (std::size_t i = 0; i < inner_.numbering.num_moving; ++i)
      if (!theirs.points.contains(i)) std::fill_n(result.begin() + 3 * static_cast<std::ptrdiff_t>(i), 3, nan);
    return result;
  };
  const auto of_rows = [&] {
    std::vector<double> result(d, nan);
    theirs.rows.for_each([&](std::size_t begin, std::size_t end) {
      for (std::size_t a = begin; a < end; ++a) result[a] = std::sin(1.0 + static_cast<double>(a));
    });
    return result;
  };
  std::vector<double> r = of_points(inner_.r), v = of_points(inner_.v), w(size, nan), blocks(3 * is_own_block.size());
  for (std::size_t k = 0; k < blocks.size(); ++k) blocks[k] = nan;
  const auto expect_own_points = [&](const std::vector<double>& x) {
    for (std::size_t i = 0; i < inner_.numbering.num_moving; ++i) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(std::isfinite(x[3 * i + c]), theirs.points.contains(i)) << i;
    }
  };
  const auto expect_own_rows = [&](const std::vector<double>& x) {
    for (std::size_t a = 0; a < d; ++a) EXPECT_EQ(std::isfinite(x[a]), theirs.rows.contains(a)) << a;
  };
  const auto expect_own_blocks = [&] {
    for (std::size_t k = 0; k < blocks.size(); ++k) EXPECT_EQ(std::isfinite(blocks[k]), is_own_block[k / 3] != 0) << k;
  };
  const Parallel parallel(2);
  std::vector<double> scratch(d, nan), lambda(d, nan);
  const Vec3 uniform{0.1, 0.2, -9.81};

  for (std::size_t i = inner_.numbering.num_moving; i < inner_.numbering.num_points(); ++i) store(w.data(), i, Vec3{});
  const Elimination found = part->solve(parallel, {r.data(), v.data(), w.data(), &uniform}, FactorUse::Renew,
                                        blocks.data(), scratch.data(), lambda.data(), w.data());
  EXPECT_GT(found.reciprocal_condition, 1e-9);
  EXPECT_LE(found.residual, 1e-12 * found.largest_right_side);
  expect_own_points(w);
  expect_own_rows(lambda);
  expect_own_blocks();

  EXPECT_GT(part->linearise(parallel, r.data(), nullptr, blocks.data()).reciprocal_condition, 1e-9);
  expect_own_blocks();
  const std::vector<double> lambda_before = lambda;
  for (std::vector<double>* const array : {&scratch, &lambda}) std::fill(array->begin(), array->end(), nan);
  std::fill_n(w.begin(), 3 * inner_.numbering.num_moving, nan);
  const Elimination again = part->solve(parallel, {r.data(), v.data(), w.data(), &uniform}, FactorUse::Keep,
                                        blocks.data(), scratch.data(), lambda.data(), w.data());
  EXPECT_NEAR(again.largest_right_side, found.largest_right_side, 1e-12 * found.largest_right_side);
  EXPECT_LE(again.residual, 1e-12 * found.largest_right_side);
  expect_own_points(w);
  expect_own_rows(lambda);
  expect_own_blocks();
  for (std::size_t a = 0; a < d; ++a) {
    if (!theirs.rows.contains(a)) continue;
    EXPECT_NEAR(lambda[a], lambda_before[a], 1e-10 * (1.0 + std::abs(lambda[a])));
  }

  std::vector<double> x = of_rows(), rows = of_rows(), points = of_points(inner_.v);
  part->solve_negative(parallel, x.data(), x.data());
  expect_own_rows(x);
  part->correct(parallel, blocks.data(), rows.data(), points.data());
  expect_own_rows(rows);
  expect_own_points(points);
  part->add_reactions(parallel, blocks.data(), x.data(), points.data());
  expect_own_points(points);

  std::vector<double> sum(d, nan);
  theirs.rows.for_each([&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) sum[a] = 1e-7;
  });
  EXPECT_LE(part->project_positions(parallel, blocks.data(), 1e-13, r.data(), nullptr, sum.data()).violation, 1e-13);
  expect_own_points(r);
  expect_own_rows(sum);
  // The violation is that of the families of constraints, not the one that the part itself reports.
  std::vector<double> rows_left(d);
  EXPECT_LE(inner_.constraints.evaluate_values(parallel, theirs.members, r.data(), rows_left.data()), 1e-12);
  EXPECT_LE(part->project_velocities(parallel, blocks.data(), 1e-12, r.data(), v.data(), nullptr).violation, 1e-12);
  EXPECT_LE(inner_.constraints.evaluate_rates(parallel, theirs.members, r.data(), v.data(), rows_left.data()), 1e-11);
  expect_own_points(v);
}

INSTANTIATE_TEST_SUITE_P(Solvers, PartsOfMixtures, testing::Values("points", "batches", "paths", "trees", "general"),
                         [](const auto& instance) { return instance.param; });

}  // namespace
}  // namespace tanor
