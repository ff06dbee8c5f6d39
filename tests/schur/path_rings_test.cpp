/// Rings are solved by the solver of paths, before any refinement: every call of it is compared with K, M and the
/// others.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "measures.hpp"
#include "schur/lane_solver.hpp"
#include "system/numbering.hpp"

namespace tanor {
using namespace detail;
namespace {

constexpr double ring_rounding = 1e-13;

/// Makes rings of these sizes, numbered at random, with rods in any order and direction. Every other rod crosses into
/// the next cell of a lattice where offsets are wanted.
System make_random_rings(const std::vector<Index>& sizes, bool with_offsets, std::mt19937* random) {
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  System system;
  Rods rods{"rods", {}, {}, {}};
  std::vector<Index> place(static_cast<std::size_t>(std::accumulate(sizes.begin(), sizes.end(), 0)));
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), *random);
  for (std::vector<double>* array : {&system.positions, &system.velocities}) array->resize(3 * place.size());
  system.masses.resize(place.size());
  auto next = place.begin();
  for (const Index size : sizes) {
    for (Index k = 0; k < size; ++k) {
      const auto i = static_cast<std::size_t>(next[k]);
      const double angle = 2.0 * std::numbers::pi * k / size, radius = size / (2.0 * std::numbers::pi);
      const Vector3 at{radius * std::cos(angle), radius * std::sin(angle), 0.5 * any(*random)};
      std::copy(at.begin(), at.end(), system.positions.begin() + 3 * next[k]);
      for (std::size_t c = 0; c < 3; ++c) system.velocities[3 * i + c] = any(*random);
      system.masses[i] = std::exp(2.0 * any(*random));
      const Index j = next[(k + 1) % size];
      rods.pairs.push_back(any(*random) > 0.0 ? std::array{next[k], j} : std::array{j, next[k]});
      if (with_offsets) rods.offsets.push_back({k % 2 == 0 ? 2.0 : 0.0, 0.5, 0.0});
    }
    next += size;
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), *random);
  system.constraints = {rods};
  return system;
}

/// All that a solver reads and writes, in the inner order.
struct Numbers {
  Numbering numbering;
  Constraints constraints;
  std::vector<Incidence> incidences;
  std::vector<double> inverse_mass, r, v, w0;
  ReactionGather gather;
  std::unique_ptr<LaneSolver> solver;

  Numbers(const System& system, std::mt19937* random)
      : numbering(number(system)),
        constraints(system, numbering),
        incidences(constraints.list_incidences()),
        inverse_mass(system.num_points()),
        gather(incidences, system.num_points()) {
    for (std::size_t i = 0; i < inverse_mass.size(); ++i)
      inverse_mass[i] = 1.0 / system.masses[static_cast<std::size_t>(numbering.user_point[i])];
    for (std::vector<double>* array : {&r, &v, &w0}) array->resize(system.positions.size());
    numbering.gather_points(system.positions, r);
    numbering.gather_points(system.velocities, v);
    std::normal_distribution<double> any(0.0, 5.0);
    for (double& w : w0) w = any(*random);
    std::vector<Index> islands(numbering.num_islands());
    std::iota(islands.begin(), islands.end(), 0);
    solver = LaneSolver::make({constraints, gather, incidences, numbering, inverse_mass, {}}, LinearSolver::Paths, 3,
                              false, &islands);
    EXPECT_TRUE(islands.empty());
  }
};

struct Solved {
  Elimination found;
  std::vector<double> blocks, b, lambda, w;
};

Solved solve(Numbers* numbers, int threads) {
  const std::size_t rows = numbers->numbering.num_rows();
  Solved result{{}, std::vector<double>(3 * rows), std::vector<double>(rows), std::vector<double>(rows), numbers->w0};
  std::vector<double> scratch(rows);
  (void)numbers->constraints.evaluate_right_side(Parallel(1), numbers->r.data(), numbers->v.data(), result.w.data(),
                                                 result.b.data(), nullptr);
  result.found = numbers->solver->solve(Parallel(threads), {numbers->r.data(), numbers->v.data(), result.w.data()},
                                        FactorUse::Renew, result.blocks.data(), scratch.data(), result.lambda.data(),
                                        result.w.data());
  return result;
}

/// Returns the residual of K'(w - w0) + b, with the positions of blocks from the families' own list.
double residual_of(const Numbers& numbers, const Solved& solved) {
  std::vector<double> rest = solved.b;
  for (const Incidence& incidence : numbers.constraints.list_incidences()) {
    const Vec3 dw = load(solved.w.data(), incidence.point) - load(numbers.w0.data(), incidence.point);
    rest[static_cast<std::size_t>(incidence.row)] +=
        incidence.sign * dot(load(solved.blocks.data(), incidence.block), dw);
  }
  return largest(rest);
}

/// Returns w0 + M^-1 K lambda.
std::vector<double> accelerations_of(const Numbers& numbers, const Solved& solved) {
  std::vector<double> w = numbers.w0;
  for (const Incidence& incidence : numbers.constraints.list_incidences()) {
    const auto point = static_cast<std::size_t>(incidence.point), row = static_cast<std::size_t>(incidence.row);
    const double factor = incidence.sign * numbers.inverse_mass[point] * solved.lambda[row];
    store(w.data(), point, load(w.data(), point) + factor * load(solved.blocks.data(), incidence.block));
  }
  return w;
}

void expect_right_numbers(const System& system, std::mt19937* random) {
  Numbers numbers(system, random);
  ASSERT_NE(numbers.solver, nullptr);
  const Solved solved = solve(&numbers, 1);
  const double scale = largest(solved.b), of_lambda = largest(solved.lambda), of_w = largest(solved.w);

  EXPECT_NEAR(solved.found.largest_right_side, scale, ring_rounding * scale);
  EXPECT_GT(solved.found.reciprocal_condition, 1e-3);
  EXPECT_LE(solved.found.residual, ring_rounding * scale);
  EXPECT_LE(residual_of(numbers, solved), ring_rounding * scale);
  EXPECT_LE(largest_difference(accelerations_of(numbers, solved), solved.w), ring_rounding * of_w);

  // A second factorization shows that nothing is left over from the first one.
  Numbers again(system, random);
  std::vector<double> blocks(solved.blocks.size());
  const Elimination factor = again.solver->linearise(Parallel(1), again.r.data(), nullptr, blocks.data());
  EXPECT_NEAR(factor.reciprocal_condition, solved.found.reciprocal_condition, ring_rounding);
  std::vector<double> x(solved.b.size()), rows = solved.b, points(solved.w.size());
  again.solver->solve_negative(Parallel(1), solved.b.data(), x.data());
  EXPECT_LE(largest_difference(x, solved.lambda), ring_rounding * of_lambda);
  x = solved.b;
  again.solver->solve_negative(Parallel(1), x.data(), x.data());
  EXPECT_LE(largest_difference(x, solved.lambda), ring_rounding * of_lambda);
  again.solver->correct(Parallel(1), solved.blocks.data(), rows.data(), points.data());
  EXPECT_LE(largest_difference(rows, solved.lambda), ring_rounding * of_lambda);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += numbers.w0[i];
  EXPECT_LE(largest_difference(points, solved.w), ring_rounding * of_w);
}

TEST(PathRings, AllCallsAgreeWithKAndM) {
  std::mt19937 random(31);
  for (const Index size : {3, 4, 5, 6, 7, 8, 9, 16, 17, 100, 129, 255, 256, 257, 258, 259, 300}) {
    for (const bool with_offsets : {false, true}) {
      SCOPED_TRACE(testing::Message() << size << " rods" << (with_offsets ? " with offsets" : ""));
      expect_right_numbers(make_random_rings({size}, with_offsets, &random), &random);
    }
  }
}

/// The multipliers of another K leave a residual that can be measured.
TEST(PathRings, TheResidualOfEachRowIsSeen) {
  std::mt19937 random(33);
  std::normal_distribution<double> slightly(1.0, 0.01);
  for (const Index size : {3, 9, 17, 40, 700}) {
    Numbers numbers(make_random_rings({size}, false, &random), &random);
    const Solved right = solve(&numbers, 1);
    for (std::size_t row = 0; row < right.b.size(); row += 1 + right.b.size() / 50) {
      // Lengthening one direction spoils its own row most.
      Solved wrong = right;
      wrong.w = numbers.w0;
      for (std::size_t c = 0; c < 3; ++c) wrong.blocks[3 * row + c] *= 1.0 + std::abs(slightly(random));
      std::vector<double> scratch(right.b.size());
      wrong.found =
          numbers.solver->solve(Parallel(1), {numbers.r.data(), numbers.v.data(), wrong.w.data()}, FactorUse::Keep,
                                wrong.blocks.data(), scratch.data(), wrong.lambda.data(), wrong.w.data());
      const double residual = residual_of(numbers, wrong);
      EXPECT_NEAR(wrong.found.residual, residual, ring_rounding * largest(right.b)) << size << " rods, row " << row;
    }
  }
}

TEST(PathRings, AllCallsAgreeForRingsSideBySide) {
  std::mt19937 random(32);
  std::vector<Index> sizes;
  for (int k = 0; k < 40; ++k) sizes.push_back(std::uniform_int_distribution<Index>(3, 400)(random));
  expect_right_numbers(make_random_rings(sizes, false, &random), &random);
}

TEST(PathRings, ThreadsGiveTheSameBits) {
  std::mt19937 random(33);
  for (const std::vector<Index>& sizes : {std::vector<Index>{9001}, {5000, 3, 7001}}) {
    Numbers numbers(make_random_rings(sizes, false, &random), &random);
    const Solved one = solve(&numbers, 1), two = solve(&numbers, 2);
    EXPECT_EQ(one.lambda, two.lambda);
    EXPECT_EQ(one.w, two.w);
    EXPECT_EQ(one.found.residual, two.found.residual);
    EXPECT_LE(one.found.residual, ring_rounding * one.found.largest_right_side);
    std::vector<double> x(one.b.size()), y(one.b.size());
    numbers.solver->solve_negative(Parallel(1), one.b.data(), x.data());
    numbers.solver->solve_negative(Parallel(2), one.b.data(), y.data());
    EXPECT_EQ(x, y);
  }
}

}  // namespace
}  // namespace tanor
