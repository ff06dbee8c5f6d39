/// Fronts as tasks give the same bits for every number of threads, and agree with CHOLMOD's simplicial factor.

#include "factor/multifrontal.hpp"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

#include "long_tests.hpp"
#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

struct LowerTriangle {
  TrianglePattern lower;
  std::vector<double> values;

  std::size_t size() const { return lower.size(); }
  double& diagonal(std::size_t j) { return values[static_cast<std::size_t>(lower.start[j])]; }
};

/// Makes random numbers in the pattern of S, with a diagonal larger than its row's sum, in an order of little fill.
LowerTriangle make_matrix(const Rods& rods, std::uint32_t seed) {
  const TrianglePattern unordered = pattern_of(rods);
  LowerTriangle S{pattern_of(rods, analyze(unordered, Ordering::Auto).permutation), {}};
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  S.values.resize(S.lower.rows.size());
  for (std::size_t j = 0; j < S.size(); ++j) S.diagonal(j) = 1.0;
  for (std::size_t j = 0; j < S.size(); ++j) {
    for (auto e = static_cast<std::size_t>(S.lower.start[j]) + 1; e < static_cast<std::size_t>(S.lower.start[j + 1]);
         ++e) {
      S.values[e] = any(generator);
      S.diagonal(j) += std::abs(S.values[e]);
      S.diagonal(static_cast<std::size_t>(S.lower.rows[e])) += std::abs(S.values[e]);
    }
  }
  return S;
}

std::vector<double> any_vector(std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t k = 0; k < n; ++k) x[k] = std::sin(1.7 * static_cast<double>(k) + 0.3);
  return x;
}

/// The diagonal of L and S^-1 b.
struct Answer {
  Cholesky::Quality quality;
  std::vector<double> pivots, x;
};
Answer answer_of(const LowerTriangle& S, int threads) {
  Multifrontal factor(S.lower);
  Answer answer{factor.factorize(S.values.data(), threads), {}, any_vector(S.size())};
  if (!answer.quality.positive_definite) return answer;
  answer.pivots = factor.pivots();
  factor.solve(answer.x.data(), threads);
  return answer;
}

/// Makes a factor of S. S by columns of its upper triangle is the lower triangle by rows.
Cholesky make_simplicial(const LowerTriangle& S) {
  const std::size_t n = S.size();
  std::vector<std::vector<std::pair<int, double>>> columns(n);
  for (std::size_t j = 0; j < n; ++j) {
    for (auto e = static_cast<std::size_t>(S.lower.start[j]); e < static_cast<std::size_t>(S.lower.start[j + 1]); ++e)
      columns[static_cast<std::size_t>(S.lower.rows[e])].emplace_back(static_cast<int>(j), S.values[e]);
  }
  TrianglePattern upper;
  std::vector<double> values;
  for (const auto& column : columns) {
    for (const auto& [row, value] : column) {
      upper.rows.push_back(row);
      values.push_back(value);
    }
    upper.start.push_back(static_cast<int>(upper.rows.size()));
  }
  Cholesky cholesky(upper, false);
  std::ranges::copy(values, cholesky.values());
  return cholesky;
}

/// Returns rods whose fronts are of all kinds, in sequences alone, whole, and in tiles with and without rows below.
std::vector<Rods> scenes() {
  return {make_net(12, 9), make_net(230, 200), make_lattice(8), make_lattice(19), make_protein(300, 4)};
}

/// Returns the supernodes in the order of cuts along axes.
Supernodes supernodes_of(const Rods& rods) {
  const SymbolicAnalysis analysis = analyze(pattern_of(rods), Ordering::Axes, [&] { return points_of(rods, 0.1); });
  return find_supernodes(pattern_of(rods, analysis.permutation));
}

TEST(Multifrontal, UpdatesTakeAFractionOfTheMemoryOfTheFactor) {
  const auto share = [](const Rods& rods) {
    const FrontTree tree(supernodes_of(rods));
    const std::size_t updates = tree.arena_size + tree.stack_size[0] + tree.stack_size[1];
    return static_cast<double>(updates) / static_cast<double>(tree.panels_size);
  };
  EXPECT_LE(share(make_net(200, 200)), 0.11);  // of a factor with few zeros
  EXPECT_LE(share(make_lattice(16)), 0.30);
  // One thread works on these, through one sequence.
  EXPECT_LE(share(make_net(100, 100)), 0.07);
  EXPECT_LE(share(make_lattice(10)), 0.25);
}

TEST(FrontTree, UpdatesThatMayBeThereTogetherShareNoRoom) {
  for (const Rods& rods : {make_net(200, 190), make_lattice(16)}) {
    const FrontTree tree(supernodes_of(rods));
    const auto generations_up = [&](int lower, int upper) {  // -1 if `upper` is not above `lower`
      int count = 0;
      for (; lower >= 0 && lower != upper; ++count) lower = tree.fronts[static_cast<std::size_t>(lower)].parent;
      return lower < 0 ? -1 : count;
    };
    std::size_t num_in_panels = 0;
    for (int a = 0; a < static_cast<int>(tree.fronts.size()); ++a) {
      const Front& front = tree.fronts[static_cast<std::size_t>(a)];
      if (!front.is_shared()) continue;
      if (front.home == Front::Home::Panels) {
        ++num_in_panels;
        const auto owner = std::ranges::find_if(tree.fronts, [&](const Front& other) {
          return other.panel <= front.update && front.update < other.panel + other.stride * other.columns;
        });
        ASSERT_NE(owner, tree.fronts.end());
        EXPECT_LE(front.update + front.update_size(), owner->panel + owner->stride * owner->columns);
        EXPECT_GE(generations_up(a, static_cast<int>(owner - tree.fronts.begin())), 2);
      } else {
        EXPECT_LE(front.update + front.update_size(), tree.arena_size);
      }
      for (int b = 0; b < a; ++b) {
        const Front& other = tree.fronts[static_cast<std::size_t>(b)];
        if (other.home != front.home || generations_up(a, b) >= 2 || generations_up(b, a) >= 2) continue;
        EXPECT_TRUE(front.update + front.update_size() <= other.update ||
                    other.update + other.update_size() <= front.update)
            << a << " and " << b;
      }
    }
    EXPECT_GT(num_in_panels, 0);
  }
}

TEST(Multifrontal, BlocksOfATriangleFollowOneAnother) {
  for (const std::size_t columns : {1u, 31u, 32u, 33u, 200u}) {
    const std::size_t stride = (columns + 7) / 8 * 8;
    std::vector<double> numbers(kernels::Triangle::size(columns, stride), 0.0);
    const kernels::Triangle triangle{numbers.data(), stride};
    for (std::size_t j = 0; j < columns; ++j) {
      for (std::size_t i = j / kernels::Triangle::width * kernels::Triangle::width; i < stride; ++i)
        triangle.column(j)[i] += 1.0;
    }
    EXPECT_TRUE(std::ranges::all_of(numbers, [](double x) { return x == 1.0; })) << columns;
  }
}

TEST(Multifrontal, EveryNumberOfThreadsGivesTheSameBits) {
  for (const Rods& rods : scenes()) {
    const LowerTriangle S = make_matrix(rods, 3);
    const Answer one = answer_of(S, 1);
    ASSERT_TRUE(one.quality.positive_definite);
    for (const int threads : {2, 3, 4, 16}) {
      const Answer more = answer_of(S, threads);
      EXPECT_EQ(one.pivots, more.pivots) << threads;
      EXPECT_EQ(one.x, more.x) << threads;
    }
  }
}

TEST(Multifrontal, SolvesAsSparseColumnsDo) {
  for (const Rods& rods : scenes()) {
    const LowerTriangle S = make_matrix(rods, 5);
    Cholesky columns = make_simplicial(S);
    ASSERT_TRUE(columns.factorize().positive_definite);
    std::vector<double> expected = any_vector(S.size());
    columns.solve(expected.data());

    const Answer answer = answer_of(S, 2);

    ASSERT_TRUE(answer.quality.positive_definite);
    double difference = 0.0;
    for (std::size_t k = 0; k < S.size(); ++k) difference = std::max(difference, std::abs(answer.x[k] - expected[k]));
    EXPECT_LE(difference, 1e-14);  // the numbers are around 0.1 and the condition is below 100
  }
}

TEST(Multifrontal, SolvesEightColumnsAtOnceAsEachAlone) {
  for (const Rods& rods : {make_net(24, 17), make_lattice(7)}) {
    const LowerTriangle S = make_matrix(rods, 3);
    const std::size_t n = S.size(), width = 8, groups = 3;
    Multifrontal factor(S.lower);
    ASSERT_TRUE(factor.factorize(S.values.data()).positive_definite);
    const std::vector<double> given = any_vector(groups * width * n);
    std::vector<double> together = given;
    factor.solve_packs(together.data(), groups);
    for (std::size_t group = 0; group < groups; ++group) {
      for (std::size_t lane = 0; lane < width; ++lane) {
        const auto at = [&](std::size_t i) { return group * width * n + width * i + lane; };
        std::vector<double> alone(n);
        for (std::size_t i = 0; i < n; ++i) alone[i] = given[at(i)];
        factor.solve(alone.data());
        for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(together[at(i)], alone[i], 1e-13) << "column " << lane;
      }
    }
  }
}

TEST(Multifrontal, FirstColumnThatFailsIsTheSameOnEveryNumberOfThreads) {
  const LowerTriangle definite[2] = {make_matrix(make_net(200, 160), 7), make_matrix(make_lattice(17), 7)};
  std::mt19937 random(9);
  for (int draw = 0; draw < num_draws(100); ++draw) {
    LowerTriangle S = definite[draw % 2];
    for (int k = 0; k < 3; ++k) S.diagonal(random() % S.size()) = -1.0;

    const Cholesky::Quality expected = make_simplicial(S).factorize();

    ASSERT_FALSE(expected.positive_definite) << draw;
    for (const int threads : {1, 2, 4}) {
      const Cholesky::Quality found = answer_of(S, threads).quality;
      EXPECT_FALSE(found.positive_definite);
      EXPECT_EQ(found.weakest_row, expected.weakest_row) << draw;
    }
  }
}

}  // namespace
}  // namespace tanor
