/// Rank, dependences and minimum-norm multipliers agree with hand examples and dense linear algebra.

#include "factor/rank_solver.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <map>
#include <numeric>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "dense.hpp"

namespace tanor {
using namespace detail;
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;
using Point = Eigen::Vector2d;

constexpr double eps = std::numeric_limits<double>::epsilon();

SparseColumns sparse(const Matrix& A) {
  SparseColumns result;
  result.num_rows = static_cast<int>(A.rows());
  for (Eigen::Index j = 0; j < A.cols(); ++j) {
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      if (A(i, j) == 0.0) continue;
      result.rows.push_back(static_cast<int>(i));
      result.values.push_back(A(i, j));
    }
    result.start.push_back(static_cast<int>(result.rows.size()));
  }
  return result;
}

/// Returns the gradients of rods between points of a plane with unit masses.
Matrix rods(const std::vector<Point>& points, const std::vector<std::array<int, 2>>& pairs) {
  Matrix K = Matrix::Zero(2 * static_cast<Eigen::Index>(points.size()), static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const Point direction = (points[static_cast<std::size_t>(j)] - points[static_cast<std::size_t>(i)]).normalized();
    K.col(static_cast<Eigen::Index>(k)).segment<2>(2 * i) = -direction;
    K.col(static_cast<Eigen::Index>(k)).segment<2>(2 * j) = direction;
  }
  return K;
}

/// Returns the solver's multipliers of S lambda = b with refinement.
Vector solve(RankSolver& solver, const Matrix& C, const Vector& b) {
  Vector lambda = Vector::Zero(C.cols());
  for (int pass = 0; pass < 3; ++pass) {
    Vector correction = b - C.transpose() * (C * lambda);
    solver.solve(correction.data());
    lambda += correction;
  }
  return lambda;
}

void expect_near(const Vector& x, const Vector& expected, double tolerance) {
  ASSERT_EQ(x.size(), expected.size());
  EXPECT_LE((x - expected).cwiseAbs().maxCoeff(), tolerance) << x.transpose() << "\nwanted\n" << expected.transpose();
}

// There are two rods in a row, and the first one is given again with a gradient twice as long. lambda_0 + 2 lambda_2
// carries the load 5.
TEST(RankSolver, SharesTheLoadOfARodThatIsGivenTwice) {
  Matrix C = rods({{0, 0}, {1, 0}, {1, 1}}, {{0, 1}, {1, 2}, {0, 1}});
  C.col(2) *= 2.0;

  RankSolver solver(sparse(C));

  EXPECT_EQ(solver.rank(), 2u);
  ASSERT_EQ(solver.dependences().size(), 1u);
  EXPECT_EQ(solver.dependences()[0].column, 2);
  ASSERT_EQ(solver.dependences()[0].terms.size(), 1u);
  EXPECT_EQ(solver.dependences()[0].terms[0].column, 0);
  EXPECT_NEAR(solver.dependences()[0].terms[0].coefficient, 1.0, 4 * eps);
  EXPECT_EQ(solver.unique(), (std::vector<bool>{false, true, false}));
  const Vector load = Vector::Map(std::vector<double>{5.0, 3.0, 0.0}.data(), 3);
  Vector lambda = solve(solver, C, C.transpose() * (C * load));
  expect_near(lambda, load, 1e-14);  // the dependent rod has no load
  solver.minimize_norm(lambda.data());
  expect_near(lambda, Eigen::Vector3d(1.0, 3.0, 2.0), 1e-14);
}

//  3---2     Six rods on four points of a plane have the rank 5 = 8 coordinates - 3 rigid motions. The sides pull
//  | X |     with 1 where the diagonals push with sqrt 2.
//  0---1
const std::vector<Point> square = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
const Matrix braced_square = rods(square, {{0, 1}, {1, 2}, {2, 3}, {0, 3}, {0, 2}, {1, 3}});

TEST(RankSolver, FindsTheSelfStressOfABracedSquare) {
  RankSolver solver(sparse(braced_square));

  EXPECT_EQ(solver.rank(), 5u);
  ASSERT_EQ(solver.dependences().size(), 1u);
  const Dependence dependence = solver.dependences()[0];
  EXPECT_EQ(dependence.column, 5);
  ASSERT_EQ(dependence.terms.size(), 5u);
  EXPECT_EQ(dependence.terms[0].column, 4);  // the other diagonal comes first
  EXPECT_NEAR(dependence.terms[0].coefficient, -1.0, 16 * eps);
  for (std::size_t k = 1; k < 5; ++k) EXPECT_NEAR(dependence.terms[k].coefficient, std::sqrt(0.5), 16 * eps);
  EXPECT_EQ(solver.unique(), std::vector<bool>(6, false));
}

TEST(RankSolver, LeavesNoSelfStressInTheSmallestMultipliers) {
  RankSolver solver(sparse(braced_square));
  Vector self_stress(6);
  self_stress << 1, 1, 1, 1, -std::sqrt(2.0), -std::sqrt(2.0);
  Vector smallest(6);  // any multipliers without it
  smallest << 3, 1, -2, -2, 5, -5;
  ASSERT_NEAR(smallest.dot(self_stress), 0.0, 1e-15);

  Vector lambda = smallest + 7.0 * self_stress;
  solver.minimize_norm(lambda.data());

  expect_near(lambda, smallest, 1e-14);
}

// All rods of the square may grow together, but a single diagonal may not.
TEST(RankSolver, TellsAContradictionFromARedundancy) {
  RankSolver solver(sparse(braced_square));
  Vector together(6), alone(6);
  together << 1, 1, 1, 1, std::sqrt(2.0), std::sqrt(2.0);
  alone << 0, 0, 0, 0, 0, 0.5;

  const auto excess = [&](const Vector& b) { return solver.contradictions({b.data(), 6}).at(0); };

  EXPECT_NEAR(excess(together).excess, 0.0, 1e-14);
  EXPECT_NEAR(excess(together).magnitude, 4.0 * std::sqrt(2.0), 1e-14);
  EXPECT_EQ(excess(alone).column, 5);
  EXPECT_NEAR(excess(alone).excess, 0.5, 1e-15);
  EXPECT_NEAR(excess(alone).magnitude, 0.5, 1e-15);
}

//  \    \    \     Three equal parallel legs, direction (3, 4)/5, carry one bar (case 18a). Along the bar the long rod
//   0----1----2    says the same as the two short ones. The legs have no part in it.
TEST(RankSolver, FindsTheRedundantRodOfAParallelogram) {
  Matrix C = Matrix::Zero(6, 6);  // x0 y0 x1 y1 x2 y2; legs 0, 1, 2; rods 0-1, 1-2, 0-2
  for (int leg = 0; leg < 3; ++leg) C.col(leg).segment<2>(2 * leg) = Point(0.6, 0.8);
  C.rightCols(3) = rods({{0, 0}, {1, 0}, {2, 0}}, {{0, 1}, {1, 2}, {0, 2}});

  RankSolver solver(sparse(C));

  EXPECT_EQ(solver.rank(), 5u);  // one motion is left, with all three points along (-4, 3)/5
  ASSERT_EQ(solver.dependences().size(), 1u);
  EXPECT_EQ(solver.dependences()[0].column, 5);
  ASSERT_EQ(solver.dependences()[0].terms.size(), 2u);
  for (const Dependence::Term& term : solver.dependences()[0].terms) EXPECT_NEAR(term.coefficient, 1.0, 16 * eps);
  EXPECT_EQ(solver.unique(), (std::vector<bool>{true, true, true, false, false, false}));
  // A tension of 2 along the whole bar goes one third through the short rods and two thirds through the long one.
  Vector lambda(6);
  lambda << 9, 8, 7, 2, 2, 0;
  solver.minimize_norm(lambda.data());
  Vector expected(6);
  expected << 9, 8, 7, 2.0 / 3.0, 2.0 / 3.0, 4.0 / 3.0;
  expect_near(lambda, expected, 1e-14);
}

TEST(RankSolver, KeepsColumnsThatAreNearlyParallel) {
  for (const double angle : {1e-4, 1e-7, 1e-10}) {
    Matrix C(3, 2);
    C << 1, std::cos(angle), 0, std::sin(angle), 0, 0;

    RankSolver solver(sparse(C));

    EXPECT_EQ(solver.rank(), 2u) << angle;
    // Two unit columns have sigma = sqrt(1 - cos).
    EXPECT_NEAR(solver.smallest_singular_value(), std::sqrt(2.0) * std::sin(angle / 2.0), 0.05 * angle) << angle;
    EXPECT_EQ(solver.unique(), std::vector<bool>(2, true)) << angle;
  }
}

// R has ones on the diagonal and -1 above. No |R_jj| of unit columns is below 1/sqrt(d), but sigma_min is about 2^-d.
TEST(RankSolver, SeesADependenceThatShowsInNoDiagonalEntry) {
  constexpr Eigen::Index d = 60;
  const Matrix R = 2.0 * Matrix::Identity(d, d) - Matrix(Matrix::Ones(d, d).triangularView<Eigen::Upper>());
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  Matrix any(80, d);
  for (double& x : any.reshaped()) x = normal(generator);
  const Matrix Q = reference::orthonormal_basis(any).leftCols(d);
  const Matrix C = Q * R;

  RankSolver solver(sparse(C));

  EXPECT_EQ(solver.rank(), d - 1);
  EXPECT_GT(solver.smallest_singular_value(), 1e-3);
  ASSERT_EQ(solver.dependences().size(), 1u);
  const Dependence& dependence = solver.dependences()[0];
  Matrix others = C.colwise().normalized();
  const Vector left_out = others.col(dependence.column);
  others.col(dependence.column).setZero();
  const Vector x = reference::solve_least_squares(others, left_out);
  EXPECT_LT((others * x - left_out).norm(), solver.tolerance());
  for (const auto& [column, coefficient] : dependence.terms) EXPECT_NEAR(coefficient, x[column], 1e-10);
}

// The same, fifty times, where neighbours share some rows.
TEST(RankSolver, SeesManyDependencesThatShowInNoDiagonalEntry) {
  constexpr Eigen::Index blocks = 50, d = 60, rows = 80, shared = 5;
  const Matrix R = 2.0 * Matrix::Identity(d, d) - Matrix(Matrix::Ones(d, d).triangularView<Eigen::Upper>());
  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  SparseColumns C;
  C.num_rows = static_cast<int>(blocks * (rows - shared) + shared);
  for (Eigen::Index block = 0; block < blocks; ++block) {
    Matrix any(rows, d);
    for (double& x : any.reshaped()) x = normal(generator);
    const Matrix part = reference::orthonormal_basis(any).leftCols(d) * R;
    for (Eigen::Index j = 0; j < d; ++j) {
      for (Eigen::Index i = 0; i < rows; ++i) {
        C.rows.push_back(static_cast<int>(block * (rows - shared) + i));
        C.values.push_back(part(i, j));
      }
      C.start.push_back(static_cast<int>(C.rows.size()));
    }
  }

  RankSolver solver(C);

  EXPECT_EQ(solver.rank(), static_cast<std::size_t>(blocks * (d - 1)));
  EXPECT_GT(solver.smallest_singular_value(), 1e-4);
}

TEST(RankSolver, GivesAColumnOfZerosNoMultiplier) {
  Matrix C = Matrix::Identity(3, 3);
  C.col(1).setZero();

  RankSolver solver(sparse(C));

  EXPECT_EQ(solver.rank(), 2u);
  ASSERT_EQ(solver.dependences().size(), 1u);
  EXPECT_EQ(solver.dependences()[0].column, 1);
  EXPECT_TRUE(solver.dependences()[0].terms.empty());
  Vector lambda(3);
  lambda << 1, 2, 3;
  solver.minimize_norm(lambda.data());
  expect_near(lambda, Eigen::Vector3d(1, 0, 3), 0.0);
}

/// The rods of a cube whose faces are n x n squares, each with the diagonal from its first corner.
struct CubeOfSquares {
  std::map<std::array<int, 3>, int> points;
  std::map<std::pair<int, int>, int> rods;  // by increasing points
  std::vector<double> lengths;
  SparseColumns C;
  std::vector<std::vector<std::pair<int, double>>> wheels;  // rods around each point inside a face, and their stress

  explicit CubeOfSquares(int n) {
    for (int face = 0; face < 6; ++face) {
      for (int u = 0; u < n; ++u) {
        for (int v = 0; v < n; ++v) {
          const auto corner = [&](int du, int dv) { return place(face, n, u + du, v + dv); };
          for (const auto& [from, to] : {std::pair{corner(0, 0), corner(1, 0)},
                                         {corner(1, 0), corner(1, 1)},
                                         {corner(1, 1), corner(0, 1)},
                                         {corner(0, 1), corner(0, 0)},
                                         {corner(0, 0), corner(1, 1)}})
            add_rod(from, to);
        }
      }
    }
    C.num_rows = 3 * static_cast<int>(points.size());
    for (int face = 0; face < 6; ++face) {
      for (int u = 1; u < n; ++u)
        for (int v = 1; v < n; ++v) add_wheel(face, n, u, v);
    }
  }

 private:
  using Place = std::array<int, 3>;

  static Place place(int face, int n, int u, int v) {
    Place at{};
    const auto axis = static_cast<std::size_t>(face % 3);
    at[axis] = face < 3 ? 0 : n;
    at[(axis + 1) % 3] = u;
    at[(axis + 2) % 3] = v;
    return at;
  }
  int number(const Place& at) { return points.try_emplace(at, static_cast<int>(points.size())).first->second; }
  static double distance(const Place& a, const Place& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

  void add_rod(const Place& from, const Place& to) {
    const int i = number(from), j = number(to), k = static_cast<int>(rods.size());
    if (!rods.try_emplace(std::minmax(i, j), k).second) return;
    lengths.push_back(distance(from, to));
    for (const auto& [point, sense] : {std::pair{i, -1.0}, std::pair{j, 1.0}}) {
      for (std::size_t c = 0; c < 3; ++c) {
        C.rows.push_back(3 * point + static_cast<int>(c));
        C.values.push_back(sense * (to[c] - from[c]) / lengths.back());
      }
    }
    C.start.push_back(static_cast<int>(C.rows.size()));
  }

  /// The six neighbours of a hub are corners of a hexagon that is affine to a regular one: forces per length of 1 in
  /// the spokes and -1 in the rim balance at each of its points.
  void add_wheel(int face, int n, int u, int v) {
    constexpr std::array<std::array<int, 2>, 6> around{{{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}}};
    auto& wheel = wheels.emplace_back();
    const Place hub = place(face, n, u, v);
    const auto add = [&](const Place& a, const Place& b, double density) {
      const int rod = rods.at(std::minmax(number(a), number(b)));
      wheel.emplace_back(rod, density * lengths[static_cast<std::size_t>(rod)]);
    };
    for (std::size_t k = 0; k < 6; ++k) {
      const auto at = [&](std::size_t m) { return place(face, n, u + around[m % 6][0], v + around[m % 6][1]); };
      add(hub, at(k), 1.0);
      add(at(k), at(k + 1), -1.0);
    }
  }
};

// Each point inside a flat face has a self-stress of its own and may leave the plane, so that 8712 = 3V - 6 rods have
// 2646 dependences. Long ones are costly: with rounding for terms these took minutes.
TEST(RankSolver, DecidesTheRankOfACubeWithManyRodsInFlatFaces) {
  const CubeOfSquares cube(22);
  ASSERT_EQ(cube.C.num_columns(), 8712u);
  const std::clock_t begin = std::clock();

  RankSolver solver(cube.C);

  EXPECT_LT(static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC, 15.0);
  EXPECT_EQ(solver.rank(), 8712u - cube.wheels.size());
  std::size_t missed = 0;
  for (const Dependence& dependence : solver.dependences()) {
    std::vector<double> rest(static_cast<std::size_t>(cube.C.num_rows));
    add_column(cube.C, dependence.column, 1.0, rest.data());
    for (const auto& [column, coefficient] : dependence.terms) {
      missed += std::abs(coefficient) > 2.0 + 1e-6 ? 1 : 0;
      add_column(cube.C, column, -coefficient, rest.data());
    }
    missed += std::ranges::any_of(rest, [](double x) { return std::abs(x) > 1e-8; }) ? 1 : 0;
  }
  EXPECT_EQ(missed, 0u);

  std::mt19937 generator(1);
  std::normal_distribution<double> normal;
  std::vector<double> lambda(8712), before, change(static_cast<std::size_t>(cube.C.num_rows));
  for (double& each : lambda) each = normal(generator);
  before = lambda;
  solver.minimize_norm(lambda.data());
  double along = 0.0;
  for (const auto& wheel : cube.wheels) {
    double sum = 0.0;
    for (const auto& [rod, stress] : wheel) sum += stress * lambda[static_cast<std::size_t>(rod)];
    along = std::max(along, std::abs(sum));
  }
  EXPECT_LT(along, 1e-11);
  for (int j = 0; j < 8712; ++j) {
    const auto k = static_cast<std::size_t>(j);
    add_column(cube.C, j, lambda[k] - before[k], change.data());
  }
  for (const double each : change) ASSERT_NEAR(each, 0.0, 1e-11);  // eps over the least singular value of Z, 2e-3
}

/// Makes sparse columns with planted dependences. Some are sums of up to three others, in any order and of any length.
Matrix make_dependent(std::uint32_t seed) {
  std::mt19937 generator(seed);
  std::normal_distribution<double> normal;
  const auto any_of = [&](Eigen::Index n) { return std::uniform_int_distribution<Eigen::Index>(0, n - 1)(generator); };
  const Eigen::Index m = 6 + any_of(40), num_free = 1 + any_of(m), num_planted = any_of(8);
  Matrix C = Matrix::Zero(m, num_free + num_planted);
  for (Eigen::Index j = 0; j < num_free; ++j)
    for (int entry = 0; entry < 4; ++entry) C(any_of(m), j) += normal(generator);
  for (Eigen::Index j = num_free; j < C.cols(); ++j)
    for (int term = 0; term < 3; ++term) C.col(j) += normal(generator) * C.col(any_of(num_free));
  std::vector<int> order(static_cast<std::size_t>(C.cols()));
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), generator);
  Matrix result(m, C.cols());
  for (Eigen::Index j = 0; j < C.cols(); ++j)
    result.col(j) = C.col(order[static_cast<std::size_t>(j)]).normalized() * std::exp(normal(generator));
  return result;
}

RC_GTEST_PROP(RankSolver, AgreesWithDenseDecompositions, ()) {
  const Matrix C = make_dependent(*rc::gen::arbitrary<std::uint32_t>());
  const Eigen::Index d = C.cols();
  const Matrix unit = C.colwise().normalized();
  Matrix V;
  const Vector sigma = reference::singular_values(unit, &V);
  RankSolver solver(sparse(C));

  // The rank is that of the singular values. R11 is nearly as well conditioned as C.
  const auto rank = (sigma.array() > solver.tolerance()).count();
  RC_LOG() << sigma.transpose() << "; tolerance " << solver.tolerance() << "\n";
  RC_ASSERT(static_cast<Eigen::Index>(solver.rank()) == rank);
  const double smallest = sigma[rank - 1];
  RC_PRE(smallest > 1e-6);
  RC_ASSERT(solver.smallest_singular_value() > smallest / (3.0 * static_cast<double>(d)));

  // The multipliers of minimum norm are C^+ of the load.
  const Vector load = Vector::LinSpaced(C.rows(), -1.0, 2.0);
  // Once in a thousand systems the default takes a planted dependence for a direction.
  RC_ASSERT(reference::rank_of(C, 1e-10) == rank);
  const Vector expected = reference::solve_least_squares(C, load, 1e-10);
  Vector lambda = solve(solver, C, C.transpose() * load);
  solver.minimize_norm(lambda.data());
  RC_ASSERT((lambda - expected).norm() <= 1e-13 / smallest * (1.0 + expected.norm()) / smallest);

  // A multiplier is unique if it is zero in every null vector.
  const std::vector<bool> unique = solver.unique();
  for (Eigen::Index k = 0; k < d; ++k) {
    const double freedom = V.row(k).tail(d - rank).norm();
    RC_ASSERT(unique[static_cast<std::size_t>(k)] == (freedom < 1e-7));
  }

  // Each dependence holds.
  for (const Dependence& dependence : solver.dependences()) {
    Vector sum = unit.col(dependence.column);
    for (const Dependence::Term& term : dependence.terms) {
      sum -= term.coefficient * unit.col(term.column);
      RC_ASSERT(std::abs(term.coefficient) <= 2.0 + 1e-6);
    }
    RC_ASSERT(sum.norm() < 1e-12 / smallest);
  }
}

}  // namespace
}  // namespace tanor
