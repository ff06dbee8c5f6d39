/// The tests compare ordering, symbolic analysis and factorization with dense linear algebra.

#include "factor/cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "factor/supernodes.hpp"
#include "random_numbers.hpp"

namespace tanor {
using namespace detail;
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Makes B B' with a unit diagonal and sparse B. Each column joins up to 4 rows, as a constraint's points do.
Matrix make_definite(int n, std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  std::uniform_int_distribution<int> any_row(0, n - 1);
  Matrix A = Matrix::Identity(n, n);
  for (int k = 0; k < n; ++k) {
    Vector b = Vector::Zero(n);
    for (int entry = 0; entry < 4; ++entry) b[any_row(generator)] = normal(generator);
    A += b * b.transpose();
  }
  const Vector scale = A.diagonal().cwiseSqrt().cwiseInverse();
  return scale.asDiagonal() * A * scale.asDiagonal();
}

Vector any_vector(Eigen::Index n, std::uint32_t seed) {
  const std::vector<double> numbers = normal_numbers(static_cast<std::size_t>(n), seed);
  return Vector::Map(numbers.data(), n);
}

/// Returns the nonzeros of the lower or upper triangle, column by column, with the diagonal.
TrianglePattern pattern_of(const Matrix& A, bool lower) {
  TrianglePattern pattern;
  for (int j = 0; j < A.cols(); ++j) {
    for (int i = 0; i < A.rows(); ++i) {
      if (i == j || ((lower ? i > j : i < j) && A(i, j) != 0.0)) pattern.rows.push_back(i);
    }
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

void fill(const Matrix& A, Cholesky* cholesky) {
  const TrianglePattern& pattern = cholesky->pattern();
  for (std::size_t j = 0; j < pattern.size(); ++j) {
    for (int k = pattern.start[j]; k < pattern.start[j + 1]; ++k) {
      cholesky->values()[k] = A(pattern.rows[static_cast<std::size_t>(k)], static_cast<Eigen::Index>(j));
    }
  }
}

Cholesky make_cholesky(const Matrix& A, bool supernodal) {
  Cholesky cholesky(pattern_of(A, supernodal), supernodal);
  fill(A, &cholesky);
  return cholesky;
}

Matrix permuted(const Matrix& A, const std::vector<int>& permutation) {
  if (permutation.empty()) return A;
  return A(permutation, permutation);
}

Vector solution(Cholesky& cholesky, const Vector& b) {
  Vector x = b;
  cholesky.solve(x.data());
  return x;
}

bool is_permutation(std::vector<int> permutation) {
  std::sort(permutation.begin(), permutation.end());
  for (std::size_t k = 0; k < permutation.size(); ++k) {
    if (permutation[k] != static_cast<int>(k)) return false;
  }
  return true;
}

// ---- solving -----------------------------------------------------------------------------------------------------

RC_GTEST_PROP(Cholesky, SolvesLikeDenseLltInEveryOrderSimplicialAndSupernodal, ()) {
  const int n = *rc::gen::inRange(1, 60).as("size");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const auto ordering =
      *rc::gen::element(Ordering::Auto, Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural);
  const bool supernodal = *rc::gen::arbitrary<bool>().as("supernodal");
  const Matrix A = make_definite(n, seed);
  const SymbolicAnalysis analysis = analyze(pattern_of(A, true), ordering);
  const Matrix ordered = permuted(A, analysis.permutation);
  const Vector b = any_vector(n, seed);
  Cholesky cholesky = make_cholesky(ordered, supernodal);

  const Cholesky::Quality quality = cholesky.factorize();
  const Vector x = solution(cholesky, b);

  RC_ASSERT(is_permutation(analysis.permutation));
  RC_ASSERT(quality.positive_definite);
  // A x - b| is at rounding, whatever the condition.
  RC_ASSERT((ordered * x - b).norm() <= 1e-13 * ordered.norm() * x.norm());
  const Vector expected = ordered.llt().solve(b);
  const Vector singular = A.jacobiSvd().singularValues();
  RC_ASSERT((x - expected).norm() <= 1e-14 * singular[0] / singular[n - 1] * expected.norm());
}

RC_GTEST_PROP(Cholesky, ReciprocalConditionIsThatOfTheDiagonalOfL, ()) {
  const int n = *rc::gen::inRange(1, 40).as("size");
  const Matrix A = make_definite(n, *rc::gen::arbitrary<std::uint32_t>().as("seed"));
  Cholesky cholesky = make_cholesky(A, *rc::gen::arbitrary<bool>().as("supernodal"));

  const Cholesky::Quality quality = cholesky.factorize();

  const Vector diagonal = Matrix(A.llt().matrixL()).diagonal();
  const double expected = std::pow(diagonal.minCoeff() / diagonal.maxCoeff(), 2);
  RC_ASSERT(std::abs(quality.reciprocal_condition - expected) <= 1e-12 * expected);
}

RC_GTEST_PROP(Cholesky, NewNumbersInTheSamePatternNeedNoNewAnalysis, ()) {
  const int n = *rc::gen::inRange(1, 40).as("size");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const Matrix first = make_definite(n, seed);
  // The zeros are the same, and every other entry is multiplied by a factor of its own.
  const Vector factors = any_vector(n, seed + 1).array().abs() + 0.1;
  const Matrix second = factors.asDiagonal() * first * factors.asDiagonal();
  const Vector b = any_vector(n, seed);
  Cholesky cholesky = make_cholesky(first, *rc::gen::arbitrary<bool>().as("supernodal"));
  RC_ASSERT(cholesky.factorize().positive_definite);
  (void)solution(cholesky, b);

  fill(second, &cholesky);
  RC_ASSERT(cholesky.factorize().positive_definite);
  const Vector x = solution(cholesky, b);

  RC_ASSERT((second * x - b).norm() <= 1e-12 * (second.norm() * x.norm()));
}

TEST(Cholesky, SolvesAgainAndAgainWithOneFactor) {
  const Matrix A = make_definite(25, 5);
  for (const bool supernodal : {false, true}) {
    Cholesky cholesky = make_cholesky(A, supernodal);
    ASSERT_TRUE(cholesky.factorize().positive_definite);

    const Vector b = any_vector(25, 1), c = any_vector(25, 2);
    const Vector x = solution(cholesky, b), y = solution(cholesky, c), again = solution(cholesky, b);

    EXPECT_EQ(x, again);
    EXPECT_LE((A * y - c).norm(), 1e-13 * y.norm());
  }
}

/// Returns a matrix as `make_definite` does, with every entry.
Matrix make_dense(int n, std::uint32_t seed) {
  Matrix B(n, n);
  for (int j = 0; j < n; ++j) B.col(j) = any_vector(n, seed + static_cast<std::uint32_t>(j));
  return B * B.transpose() / n + Matrix::Identity(n, n);
}

TEST(Cholesky, FrontsOfEverySizeAreThoseOfDenseLlt) {
  // Sizes lie around the numbers of columns and rows that are processed at once, which are 4, 8, 16, 64 and 512.
  for (const int n : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 14, 15, 16, 17, 63, 64, 65, 68, 127, 129, 511, 513, 600}) {
    const Matrix A = make_dense(n, 7);
    const Vector b = any_vector(n, 1);
    Cholesky cholesky = make_cholesky(A, true);

    ASSERT_TRUE(cholesky.factorize().positive_definite);

    EXPECT_LE((solution(cholesky, b) - A.llt().solve(b)).norm(), 1e-13 * b.norm()) << n;
  }
}

/// Columns after a pivot of 0 have no finite pivots either.
TEST(Cholesky, FirstOfSeveralColumnsThatFailIsTold) {
  constexpr int n = 12;
  for (int k = 0; k + 1 < n; ++k) {
    Matrix A = Matrix::Identity(n, n);
    A(k, k) = 0.0;
    A(k + 1, k) = A(k, k + 1) = 1.0;
    Cholesky cholesky = make_cholesky(A, true);

    const Cholesky::Quality quality = cholesky.factorize();

    EXPECT_FALSE(quality.positive_definite);
    EXPECT_EQ(quality.weakest_row, static_cast<std::size_t>(k));
  }
}

TEST(Cholesky, ArrowWithManyArmsAddsAllTheirUpdates) {
  // There are 40 dense arms of 3, each joined to a dense head of 90 at other places, which is one front with 40
  // children.
  constexpr int arms = 40, arm = 3, head = 90, n = arms * arm + head;
  Matrix A = Matrix::Zero(n, n);
  A.bottomRightCorner(head, head) = make_dense(head, 3);
  for (int k = 0; k < arms; ++k) {
    const Matrix B = make_dense(arm, static_cast<std::uint32_t>(k));
    A.block(arm * k, arm * k, arm, arm) = B;
    for (int j = 0; j < 5; ++j) {
      const int row = arms * arm + (17 * k + 31 * j) % head;
      A.block(row, arm * k, 1, arm).setConstant(0.1 / (1 + j));
      A.block(arm * k, row, arm, 1).setConstant(0.1 / (1 + j));
    }
  }
  const Vector b = any_vector(n, 2);
  Cholesky cholesky = make_cholesky(A, true);

  ASSERT_TRUE(cholesky.factorize().positive_definite);

  EXPECT_LE((solution(cholesky, b) - A.llt().solve(b)).norm(), 1e-13 * b.norm());
}

TEST(Cholesky, TwoByTwoIsSolvedByHand) {
  // [4 2; 2 3] x = [2; 5] has the solution x = (-0.5, 2).
  const Matrix A{{4.0, 2.0}, {2.0, 3.0}};
  for (const bool supernodal : {false, true}) {
    Cholesky cholesky = make_cholesky(A, supernodal);
    ASSERT_TRUE(cholesky.factorize().positive_definite);

    const Vector x = solution(cholesky, Vector{{2.0, 5.0}});

    EXPECT_NEAR(x[0], -0.5, 1e-15);
    EXPECT_NEAR(x[1], 2.0, 1e-15);
  }
}

/// Makes rows that share one more row, which comes first or last. If it is eliminated first, it fills L with n (n +
/// 1)/2 nonzeros from 2n - 1.
TrianglePattern make_arrow(int n, bool tip_first) {
  TrianglePattern arrow;
  for (int column = 0; column < n; ++column) {
    arrow.rows.push_back(column);
    for (int row = column + 1; row < n && tip_first && column == 0; ++row) arrow.rows.push_back(row);
    if (!tip_first && column + 1 < n) arrow.rows.push_back(n - 1);
    arrow.start.push_back(static_cast<int>(arrow.rows.size()));
  }
  return arrow;
}

TEST(Cholesky, FactorsOfMoreNonzerosThanAnIntCountsAreAnalyzed) {
  constexpr int n = 70000;
  constexpr double full = 0.5 * n * (n + 1.0);
  static_assert(full > 2147483647.0);
  const TrianglePattern arrow = make_arrow(n, true);

  const SymbolicAnalysis as_given = analyze(arrow, Ordering::Natural), ordered = analyze(arrow, Ordering::Auto);
  const Supernodes filled = find_supernodes(arrow), sparse = find_supernodes(make_arrow(n, false));

  EXPECT_EQ(as_given.factor_nonzeros, full);
  EXPECT_TRUE(as_given.supernodal);
  EXPECT_EQ(filled.size(), 1U);
  EXPECT_EQ(filled.num_stored(), full);
  EXPECT_EQ(ordered.factor_nonzeros, 2.0 * n - 1.0);
  EXPECT_LT(sparse.num_stored(), 2.1 * n);
}

// ---- matrices without a factor -----------------------------------------------------------------------------------

/// Returns the first column whose leading block is not positive definite.
std::size_t first_bad_column(const Matrix& A) {
  for (Eigen::Index k = 1; k <= A.cols(); ++k) {
    if (A.topLeftCorner(k, k).llt().info() != Eigen::Success) return static_cast<std::size_t>(k - 1);
  }
  return static_cast<std::size_t>(A.cols());
}

RC_GTEST_PROP(Cholesky, IndefiniteMatrixIsReportedWithItsColumn, ()) {
  const int n = *rc::gen::inRange(1, 40).as("size");
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const int column = *rc::gen::inRange(0, n).as("column");
  Matrix A = make_definite(n, seed);
  A(column, column) = -0.5;
  Cholesky cholesky = make_cholesky(A, *rc::gen::arbitrary<bool>().as("supernodal"));

  const Cholesky::Quality quality = cholesky.factorize();

  RC_ASSERT(!quality.positive_definite);
  RC_ASSERT(quality.weakest_row == first_bad_column(A));
  RC_ASSERT(quality.reciprocal_condition == 0.0);
}

TEST(Cholesky, GoodNumbersAfterBadOnesAreFactorizedAgain) {
  const Matrix A = make_definite(12, 3);
  Matrix bad = A;
  bad(4, 4) = -1.0;
  const Vector b = any_vector(12, 1);
  for (const bool supernodal : {false, true}) {
    Cholesky cholesky = make_cholesky(A, supernodal);
    fill(bad, &cholesky);
    EXPECT_FALSE(cholesky.factorize().positive_definite);

    fill(A, &cholesky);
    ASSERT_TRUE(cholesky.factorize().positive_definite);

    EXPECT_LE((A * solution(cholesky, b) - b).norm(), 1e-13 * b.norm());
  }
}

/// Makes G G' of rows G that are unit vectors. The last one repeats row `twin`, so that the matrix is exactly singular.
Matrix make_singular(int n, int twin, std::uint32_t seed) {
  Matrix G(n, n + 3);
  for (int i = 0; i < n; ++i) G.row(i) = any_vector(n + 3, seed + static_cast<std::uint32_t>(i)).normalized();
  G.row(n - 1) = G.row(twin);
  return G * G.transpose();
}

RC_GTEST_PROP(Cholesky, ExactlySingularMatrixIsNotPositiveDefiniteOrHasNoCondition, ()) {
  const int n = *rc::gen::inRange(2, 30).as("size");
  const int twin = *rc::gen::inRange(0, n - 1).as("row that the last one repeats");
  const Matrix A = make_singular(n, twin, *rc::gen::arbitrary<std::uint32_t>().as("seed"));
  Cholesky cholesky = make_cholesky(A, *rc::gen::arbitrary<bool>().as("supernodal"));

  const Cholesky::Quality quality = cholesky.factorize();

  RC_ASSERT(!quality.positive_definite || quality.reciprocal_condition < 3e-14);
  // In both cases the named column is the last one, where the singularity shows.
  RC_ASSERT(quality.weakest_row == static_cast<std::size_t>(n - 1));
}

TEST(Cholesky, NumbersThatAreNotFiniteHaveNoFactor) {
  Matrix A = make_definite(6, 2);
  A(3, 3) = NAN;
  for (const bool supernodal : {false, true}) {
    Cholesky cholesky = make_cholesky(A, supernodal);

    const Cholesky::Quality quality = cholesky.factorize();

    EXPECT_FALSE(quality.positive_definite && quality.reciprocal_condition > 0.0);
  }
}

// ---- what the analysis finds -------------------------------------------------------------------------------------

/// Returns the lower triangle of a matrix whose graph has the given edges (row > column).
TrianglePattern pattern_of_edges(int n, std::vector<std::pair<int, int>> edges) {
  for (int j = 0; j < n; ++j) edges.emplace_back(j, j);
  std::sort(edges.begin(), edges.end());  // (column, row)
  TrianglePattern pattern;
  for (int j = 0, k = 0; j < n; ++j) {
    for (; k < static_cast<int>(edges.size()) && edges[static_cast<std::size_t>(k)].first == j; ++k) {
      pattern.rows.push_back(edges[static_cast<std::size_t>(k)].second);
    }
    pattern.start.push_back(k);
  }
  return pattern;
}

TrianglePattern lattice(int side) {
  std::vector<std::pair<int, int>> edges;
  const auto node = [&](int x, int y, int z) { return (x * side + y) * side + z; };
  for (int x = 0; x < side; ++x) {
    for (int y = 0; y < side; ++y) {
      for (int z = 0; z < side; ++z) {
        if (x + 1 < side) edges.emplace_back(node(x, y, z), node(x + 1, y, z));
        if (y + 1 < side) edges.emplace_back(node(x, y, z), node(x, y + 1, z));
        if (z + 1 < side) edges.emplace_back(node(x, y, z), node(x, y, z + 1));
      }
    }
  }
  return pattern_of_edges(side * side * side, edges);
}

TEST(Analysis, ChainKeepsItsOrderWithoutFillAndStaysSimplicial) {
  std::vector<std::pair<int, int>> edges;
  for (int k = 0; k + 1 < 1000; ++k) edges.emplace_back(k, k + 1);
  const TrianglePattern pattern = pattern_of_edges(1000, edges);

  const SymbolicAnalysis analysis = analyze(pattern, Ordering::Auto);

  EXPECT_EQ(analysis.ordering, Ordering::Natural);
  EXPECT_TRUE(analysis.permutation.empty());
  EXPECT_EQ(analysis.factor_nonzeros, 1999.0);
  EXPECT_FALSE(analysis.supernodal);
}

TEST(Analysis, TreeFromItsLeavesOnHasNoFill) {
  // In this binary tree the root is last, and node k hangs on a later one.
  std::vector<std::pair<int, int>> edges;
  for (int k = 1; k < 1023; ++k) edges.emplace_back(1022 - k, 1022 - (k - 1) / 2);
  const TrianglePattern pattern = pattern_of_edges(1023, edges);

  const SymbolicAnalysis analysis = analyze(pattern, Ordering::Auto);

  EXPECT_EQ(analysis.ordering, Ordering::Natural);
  EXPECT_EQ(analysis.factor_nonzeros, static_cast<double>(pattern.rows.size()));
  EXPECT_FALSE(analysis.supernodal);
}

TEST(Analysis, StarFromItsHubOnIsReorderedAndLosesItsFill) {
  // Eliminating the hub first would fill everything.
  std::vector<std::pair<int, int>> edges;
  for (int k = 1; k < 200; ++k) edges.emplace_back(0, k);
  const TrianglePattern pattern = pattern_of_edges(200, edges);

  const SymbolicAnalysis analysis = analyze(pattern, Ordering::Auto);

  EXPECT_EQ(analysis.ordering, Ordering::Amd);
  EXPECT_TRUE(is_permutation(analysis.permutation) && analysis.permutation.size() == 200);
  EXPECT_EQ(analysis.factor_nonzeros, 399.0);
}

TEST(Analysis, LatticeOfThreeDimensionsIsDenseEnoughForSupernodes) {
  const SymbolicAnalysis analysis = analyze(lattice(16), Ordering::Auto);

  EXPECT_TRUE(analysis.supernodal);
  EXPECT_NE(analysis.ordering, Ordering::Natural);
}

/// Returns 7 minus the lattice's adjacency, which is definite and well conditioned.
Matrix matrix_of(const TrianglePattern& lower) {
  const auto n = static_cast<Eigen::Index>(lower.size());
  Matrix A = Matrix::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    for (int k = lower.start[static_cast<std::size_t>(j)]; k < lower.start[static_cast<std::size_t>(j) + 1]; ++k) {
      const int i = lower.rows[static_cast<std::size_t>(k)];
      A(i, j) = A(j, i) = i == j ? 7.0 : -1.0;
    }
  }
  return A;
}

TEST(Cholesky, FrontsAndSparseColumnsAgreeOnALatticeInEveryOrder) {
  const Matrix A = matrix_of(lattice(9));
  const Vector b = any_vector(A.cols(), 4);
  for (const Ordering ordering : {Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural}) {
    const std::vector<int> permutation = analyze(lattice(9), ordering).permutation;
    const Matrix ordered = permuted(A, permutation);
    Cholesky fronts = make_cholesky(ordered, true), columns = make_cholesky(ordered, false);
    const Cholesky::Quality of_fronts = fronts.factorize(), of_columns = columns.factorize();
    ASSERT_TRUE(of_fronts.positive_definite && of_columns.positive_definite);

    EXPECT_LE((solution(fronts, b) - solution(columns, b)).norm(), 1e-14 * b.norm());
    EXPECT_NEAR(of_fronts.reciprocal_condition, of_columns.reciprocal_condition, 1e-14);
  }
}

TEST(Analysis, ForcedOrderingIsUsed) {
  const TrianglePattern pattern = lattice(6);
  for (const Ordering wanted : {Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural}) {
    const SymbolicAnalysis analysis = analyze(pattern, wanted);

    EXPECT_EQ(analysis.ordering, wanted);
    EXPECT_EQ(analysis.permutation.empty(), wanted == Ordering::Natural);
    EXPECT_TRUE(is_permutation(analysis.permutation));
  }
}

TEST(Analysis, AutoIsNeverMoreWorkThanNaturalOrAmd) {
  for (const int side : {3, 6, 12}) {
    const TrianglePattern pattern = lattice(side);

    const double chosen = analyze(pattern, Ordering::Auto).flops;

    EXPECT_LE(chosen, analyze(pattern, Ordering::Natural).flops);
    EXPECT_LE(chosen, analyze(pattern, Ordering::Amd).flops);
  }
}

RC_GTEST_PROP(Analysis, PredictsTheNonzerosOfTheFactor, ()) {
  const int n = *rc::gen::inRange(1, 40).as("size");
  const Matrix A = make_definite(n, *rc::gen::arbitrary<std::uint32_t>().as("seed"));
  const auto ordering = *rc::gen::element(Ordering::Amd, Ordering::Metis, Ordering::Nesdis, Ordering::Natural);

  const SymbolicAnalysis analysis = analyze(pattern_of(A, true), ordering);

  const Matrix L = permuted(A, analysis.permutation).llt().matrixL();
  const auto nonzeros = static_cast<double>((L.array() != 0.0).count());
  // Numbers may cancel to 0 inside the pattern, and nothing may lie outside it.
  RC_ASSERT(nonzeros <= analysis.factor_nonzeros);
  RC_ASSERT(nonzeros >= 0.95 * analysis.factor_nonzeros);
}

}  // namespace
}  // namespace tanor
