/// The tests compare S, written by gathering, with the dense product K'M^-1K.

#include "assembly/gather_plan.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "linearised.hpp"

namespace tanor {
using namespace detail;
namespace {

/// K as random blocks, since the plan knows nothing of constraints.
struct RandomBlocks {
  std::vector<Incidence> incidences;
  std::vector<double> inverse_masses, blocks;
  int num_rows = 0, num_points = 0;

  Eigen::MatrixXd S() const {
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3 * num_points, num_rows);
    Eigen::VectorXd inverse_M(3 * num_points);
    for (int i = 0; i < num_points; ++i) {
      inverse_M.segment<3>(3 * i).setConstant(inverse_masses[static_cast<std::size_t>(i)]);
    }
    for (const auto& [point, row, block, sign] : incidences) {
      K.block<3, 1>(3 * point, row) += sign * reference::point(blocks, block);
    }
    return K.transpose() * inverse_M.asDiagonal() * K;
  }
};

/// Makes rows that touch 1 to 4 points each. Half of those with two points share one block, as rods do. There are few
/// points and many rows, so that a point has several rows and pairs of rows share several points.
RandomBlocks make_random_blocks(int num_points, int num_rows, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  RandomBlocks result;
  result.num_points = num_points;
  result.num_rows = num_rows;
  for (int i = 0; i < num_points; ++i) result.inverse_masses.push_back(std::exp(normal(generator)));
  Index num_blocks = 0;
  std::vector<Index> points(static_cast<std::size_t>(num_points));
  std::iota(points.begin(), points.end(), 0);
  for (int row = 0; row < num_rows; ++row) {
    std::shuffle(points.begin(), points.end(), generator);
    const int touched = std::min(num_points, std::uniform_int_distribution<int>(1, 4)(generator));
    if (touched == 2 && normal(generator) > 0.0) {
      result.incidences.push_back({points[0], row, num_blocks, -1.0});
      result.incidences.push_back({points[1], row, num_blocks, 1.0});
      ++num_blocks;
    } else {
      for (int k = 0; k < touched; ++k) result.incidences.push_back({points[k], row, num_blocks++, 1.0});
    }
  }
  for (Index k = 0; k < 3 * num_blocks; ++k) result.blocks.push_back(normal(generator));
  std::stable_sort(result.incidences.begin(), result.incidences.end(),
                   [](const Incidence& a, const Incidence& b) { return a.point < b.point; });
  return result;
}

std::vector<int> any_permutation(int size, std::uint32_t seed) {
  std::vector<int> result(static_cast<std::size_t>(size));
  std::iota(result.begin(), result.end(), 0);
  std::shuffle(result.begin(), result.end(), std::mt19937(seed));
  return result;
}

/// Returns both halves of the triangle that the plan writes, in the order of elimination and without its scale.
Eigen::MatrixXd unscaled(const GatherPlan& plan, const std::vector<double>& values) {
  const auto n = static_cast<Eigen::Index>(plan.column_start().size()) - 1;
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
  for (int j = 0; j < n; ++j) {
    for (int k = plan.column_start()[static_cast<std::size_t>(j)];
         k < plan.column_start()[static_cast<std::size_t>(j) + 1]; ++k) {
      const auto slot = static_cast<std::size_t>(k);
      const int i = plan.rows()[slot];
      const double value =
          values[slot] / (plan.scale()[static_cast<std::size_t>(i)] * plan.scale()[static_cast<std::size_t>(j)]);
      result(i, j) = result(j, i) = value;
    }
  }
  return result;
}

Eigen::MatrixXd permuted(const Eigen::MatrixXd& S, const std::vector<int>& place) {
  Eigen::MatrixXd result(S.rows(), S.cols());
  for (Eigen::Index i = 0; i < S.rows(); ++i) {
    for (Eigen::Index j = 0; j < S.cols(); ++j) {
      result(place[static_cast<std::size_t>(i)], place[static_cast<std::size_t>(j)]) = S(i, j);
    }
  }
  return result;
}

/// Returns |computed - expected| relative to sqrt(S_ii S_jj), the size that an entry of S can have.
double largest_error(const Eigen::MatrixXd& computed, const Eigen::MatrixXd& expected) {
  const Eigen::VectorXd root = expected.diagonal().cwiseSqrt();
  return expected.size() == 0
             ? 0.0
             : ((computed - expected).cwiseAbs().array() / (root * root.transpose()).array()).maxCoeff();
}

RC_GTEST_PROP(GatherPlan, WritesTheDenseProductInEitherTriangleAndAnyOrder, ()) {
  const int num_points = *rc::gen::inRange(1, 12).as("points");
  const int num_rows = *rc::gen::inRange(1, 20).as("rows");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const auto triangle = *rc::gen::element(Triangle::Lower, Triangle::Upper);
  const RandomBlocks random = make_random_blocks(num_points, num_rows, seed);
  const std::vector<int> place = any_permutation(num_rows, seed);
  GatherPlan plan(list_products(random.incidences, random.inverse_masses, 0), static_cast<std::size_t>(num_rows), place,
                  triangle);
  std::vector<double> values(plan.rows().size());

  plan.assemble(random.blocks.data(), values.data());

  RC_ASSERT(largest_error(unscaled(plan, values), permuted(random.S(), place)) <= 1e-14);
}

RC_GTEST_PROP(GatherPlan, PatternIsOneSortedTriangleWithItsDiagonal, ()) {
  const int num_rows = *rc::gen::inRange(1, 20).as("rows");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const auto triangle = *rc::gen::element(Triangle::Lower, Triangle::Upper);
  const RandomBlocks random = make_random_blocks(8, num_rows, seed);

  const GatherPlan plan(list_products(random.incidences, random.inverse_masses, 0), static_cast<std::size_t>(num_rows),
                        any_permutation(num_rows, seed), triangle);

  for (int j = 0; j < num_rows; ++j) {
    const auto begin = plan.rows().begin() + plan.column_start()[static_cast<std::size_t>(j)];
    const auto end = plan.rows().begin() + plan.column_start()[static_cast<std::size_t>(j) + 1];
    RC_ASSERT(std::adjacent_find(begin, end, std::greater_equal<>()) == end);
    RC_ASSERT(begin != end && (triangle == Triangle::Lower ? *begin : *(end - 1)) == j);
  }
}

RC_GTEST_PROP(GatherPlan, ScalesSToAUnitDiagonal, ()) {
  const int num_rows = *rc::gen::inRange(1, 20).as("rows");
  const RandomBlocks random = make_random_blocks(8, num_rows, *rc::gen::arbitrary<std::uint32_t>().as("seed"));
  GatherPlan plan(list_products(random.incidences, random.inverse_masses, 0), static_cast<std::size_t>(num_rows), {},
                  Triangle::Lower);
  std::vector<double> values(plan.rows().size());

  plan.assemble(random.blocks.data(), values.data());

  const Eigen::MatrixXd S = random.S();
  for (int j = 0; j < num_rows; ++j) {
    const auto column = static_cast<std::size_t>(j);
    RC_ASSERT(std::abs(values[static_cast<std::size_t>(plan.column_start()[column])] - 1.0) <= 1e-15);
    RC_ASSERT(std::abs(plan.scale()[column] * std::sqrt(S(j, j)) - 1.0) <= 1e-14);
  }
}

RC_GTEST_PROP(GatherPlan, PartOfTheRowsIsAPartOfS, ()) {
  // The rows are those of the second of two separate halves of the points. The plan subtracts the half's first row,
  // 100.
  const int half = *rc::gen::inRange(1, 10).as("rows of each half");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const RandomBlocks random = make_random_blocks(6, half, seed);
  std::vector<Incidence> shifted = random.incidences;
  for (Incidence& incidence : shifted) incidence.row += 100;
  GatherPlan plan(list_products(shifted, random.inverse_masses, 100), static_cast<std::size_t>(half), {},
                  Triangle::Lower);
  std::vector<double> values(plan.rows().size());

  plan.assemble(random.blocks.data(), values.data());

  RC_ASSERT(largest_error(unscaled(plan, values), random.S()) <= 1e-14);
}

RC_GTEST_PROP(GatherPlan, WritesTheDenseProductOfRandomSystems, ()) {
  const RandomSystem random = any_system();
  const Linearised inner(random);
  const std::size_t d = inner.constraints.num_rows();
  std::vector<Incidence> moving;
  for (const Incidence& incidence : inner.incidences) {
    if (inner.inverse_masses[static_cast<std::size_t>(incidence.point)] > 0.0) moving.push_back(incidence);
  }
  std::stable_sort(moving.begin(), moving.end(),
                   [](const Incidence& a, const Incidence& b) { return a.point < b.point; });
  GatherPlan plan(list_products(moving, inner.inverse_masses, 0), d, {}, Triangle::Upper,
                  inner.constraints.squared_gradient_norms());
  std::vector<double> values(plan.rows().size());

  plan.assemble(inner.blocks.data(), values.data());

  RC_ASSERT(largest_error(unscaled(plan, values), inner.S()) <= 1e-14);
}

TEST(GatherPlan, RodMeetsItsNeighbourWithTheCosineBetweenThemOverTheSharedMass) {
  // 0 --rod 0-- 1 --rod 1-- 2 with an angle of 120 degrees: u0.u1 = cos 60 = 0.5, both signs at point 1: -0.5/m1.
  //   S = [1/m0 + 1/m1, -0.5/m1; ., 1/m1 + 1/m2] = [1.5, -0.25; ., 0.75] for masses 1, 2, 4
  const std::vector<Incidence> incidences = {{0, 0, 0, -1.0}, {1, 0, 0, 1.0}, {1, 1, 1, -1.0}, {2, 1, 1, 1.0}};
  const std::vector<double> inverse_masses = {1.0, 0.5, 0.25};
  const std::vector<double> blocks = {1.0, 0.0, 0.0, 0.5, std::sqrt(0.75), 0.0};
  GatherPlan plan(list_products(incidences, inverse_masses, 0), 2, {}, Triangle::Lower);
  std::vector<double> values(3);

  plan.assemble(blocks.data(), values.data());

  const Eigen::MatrixXd S = unscaled(plan, values);
  EXPECT_EQ(plan.rows(), (std::vector{0, 1, 1}));
  EXPECT_NEAR(S(0, 0), 1.5, 1e-15);
  EXPECT_NEAR(S(1, 0), -0.25, 1e-15);
  EXPECT_NEAR(S(1, 1), 0.75, 1e-15);
}

/// Returns |g|^2 of each block.
std::vector<double> squared_norms(const RandomBlocks& random) {
  std::vector<double> result;
  for (Index k = 0; k < static_cast<Index>(random.blocks.size() / 3); ++k) {
    result.push_back(reference::point(random.blocks, k).squaredNorm());
  }
  return result;
}

TEST(GatherPlan, KnownNormsScaleTheWeightsOnceForAll) {
  RandomBlocks random = make_random_blocks(5, 9, 3);
  GatherPlan plan(list_products(random.incidences, random.inverse_masses, 0), 9, {}, Triangle::Lower,
                  squared_norms(random));
  std::vector<double> values(plan.rows().size());
  const std::vector<double> scale = plan.scale();

  // Turned blocks have the same lengths.
  for (auto block = random.blocks.begin(); block != random.blocks.end(); block += 3) {
    std::rotate(block, block + 1, block + 3);
  }
  plan.assemble(random.blocks.data(), values.data());

  EXPECT_EQ(plan.scale(), scale);
  EXPECT_LE(largest_error(unscaled(plan, values), random.S()), 1e-14);
  for (std::size_t j = 0; j < 9; ++j) {
    EXPECT_NEAR(values[static_cast<std::size_t>(plan.column_start()[j])], 1.0, 1e-15);
  }
}

TEST(GatherPlan, EveryNumberOfThreadsWritesTheSameBits) {
  constexpr int num_rows = 9000;
  const RandomBlocks random = make_random_blocks(1500, num_rows, 11);
  const std::vector<Product> products = list_products(random.incidences, random.inverse_masses, 0);
  GatherPlan plan(products, num_rows, any_permutation(num_rows, 3), Triangle::Lower);
  std::vector<double> one(plan.rows().size());
  plan.assemble(random.blocks.data(), one.data());
  const std::vector<double> scale = plan.scale();
  for (const int threads : {2, 4, 16}) {
    std::vector<double> more(one.size());
    plan.assemble(random.blocks.data(), more.data(), Parallel(threads));
    EXPECT_EQ(one, more) << threads;
    EXPECT_EQ(scale, plan.scale()) << threads;
  }
}

TEST(GatherPlan, ForgetsTheStatesThatItHasSeen) {
  const RandomBlocks random = make_random_blocks(5, 9, 3), other = make_random_blocks(5, 9, 4);
  std::vector<double> bad = other.blocks;
  bad.resize(random.blocks.size(), 1.0);
  bad[7] = NAN;
  for (const bool norms_are_known : {false, true}) {
    const std::vector<double> norms = norms_are_known ? squared_norms(random) : std::vector<double>();
    GatherPlan plan(list_products(random.incidences, random.inverse_masses, 0), 9, {}, Triangle::Lower, norms);
    std::vector<double> first(plan.rows().size()), again(first), between(first);

    plan.assemble(random.blocks.data(), first.data());
    plan.assemble(bad.data(), between.data());
    plan.assemble(random.blocks.data(), again.data());

    EXPECT_EQ(first, again);
    EXPECT_LE(largest_error(unscaled(plan, again), random.S()), 1e-14);
  }
}

TEST(GatherPlan, MoreProductsThanAnIntCountsAreRefusedBeforeTheyAreMade) {
  // All 65536 rows share one point, which makes 65536 * 65537/2 = 2^31 + 2^15 products.
  std::vector<Incidence> hub;
  for (Index row = 0; row < 65536; ++row) hub.push_back({0, row, row, 1.0});
  try {
    (void)list_products(hub, std::vector<double>{1.0}, 0);
    FAIL() << "2147516416 products were made";
  } catch (const std::length_error& error) {
    EXPECT_NE(std::string(error.what()).find("2147516416 products"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace tanor
