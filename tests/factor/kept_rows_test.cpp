/// For rows that are kept, the Schur complement agrees with a dense one, and solves agree with those of a whole factor.

#include "factor/multifrontal.hpp"

#include <cmath>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <Eigen/Dense>

#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

/// S = C'C of unit columns C in an order that keeps some rows, and further terms on the diagonal.
struct Problem {
  TrianglePattern lower;
  std::vector<double> values;
  std::size_t num_kept;

  Eigen::MatrixXd dense() const {
    const auto n = static_cast<Eigen::Index>(lower.size());
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t j = 0; j < lower.size(); ++j) {
      for (auto e = static_cast<std::size_t>(lower.start[j]); e < static_cast<std::size_t>(lower.start[j + 1]); ++e)
        S(lower.rows[e], static_cast<int>(j)) = S(static_cast<int>(j), lower.rows[e]) = values[e];
    }
    return S;
  }
};

/// The factor of a problem with its values filled in.
struct Factor : Multifrontal {
  std::vector<double> values;

  explicit Factor(const Problem& of) : Multifrontal(of.lower, of.num_kept), values(of.values) {}
  Cholesky::Quality factorize(int threads = 1) { return Multifrontal::factorize(values.data(), threads); }
};

/// Makes a problem. Points for which `is_massless` holds count as supports. They are the ends of cut rods in another
/// part.
template <class IsKept, class IsMassless>
Problem make_problem(const Rods& rods, const IsKept& is_kept, const IsMassless& is_massless) {
  std::vector<char> kept;
  for (const auto& [a, b] : rods.ends) kept.push_back(is_kept(a, b) ? 1 : 0);
  const std::vector<int> order = order_keeping(pattern_of(rods), kept, Ordering::Auto);
  Problem problem{pattern_of(rods, order), {}, static_cast<std::size_t>(std::ranges::count(kept, 1))};
  const SparseColumns C = gradients_of(rods, 5);
  const auto column = [&](std::size_t place, int point) -> const double* {
    const auto k = static_cast<std::size_t>(order[place]);
    for (int e = C.start[k]; e < C.start[k + 1]; ++e)
      if (C.rows[static_cast<std::size_t>(e)] == 3 * point) return &C.values[static_cast<std::size_t>(e)];
    return nullptr;
  };
  for (std::size_t j = 0; j < problem.lower.size(); ++j) {
    const auto [a, b] = rods.ends[static_cast<std::size_t>(order[j])];
    for (auto e = static_cast<std::size_t>(problem.lower.start[j]);
         e < static_cast<std::size_t>(problem.lower.start[j + 1]); ++e) {
      double sum = 0.0;
      for (const int point : {a, b}) {
        const double* const other = column(static_cast<std::size_t>(problem.lower.rows[e]), point);
        const double* const own = column(j, point);
        for (int c = 0; c < 3 && other != nullptr && !is_massless(point); ++c) sum += own[c] * other[c];
      }
      problem.values.push_back(sum);
    }
  }
  return problem;
}

constexpr auto nowhere = [](int) { return false; };

Eigen::MatrixXd complement_of(const Multifrontal& factor) {
  const auto n = static_cast<Eigen::Index>(factor.num_kept());
  std::vector<double> packed(factor.complement_size());
  factor.write_complement(packed.data());
  Eigen::MatrixXd C(n, n);
  std::size_t next = 0;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = j; i < n; ++i) C(i, j) = C(j, i) = packed[next++];
  return C;
}

Eigen::MatrixXd dense_complement(const Problem& problem) {
  const Eigen::MatrixXd S = problem.dense();
  const auto g = static_cast<Eigen::Index>(problem.num_kept), n = S.rows() - g;
  if (g == 0 || n == 0) return S.bottomRightCorner(g, g);  // Eigen would look for the first of no right sides
  return S.bottomRightCorner(g, g) -
         S.bottomLeftCorner(g, n) * S.topLeftCorner(n, n).llt().solve(S.topRightCorner(n, g));
}

/// Makes the rods of nets cut along a line and of lattices cut along a face. The rods that cross the middle are kept.
Problem cut_net(int columns, int rows) {
  const auto side = [=](int point) { return point / rows < columns / 2; };
  return make_problem(
      make_net(columns, rows), [=](int a, int b) { return side(a) != side(b); }, nowhere);
}
Problem cut_lattice(int n) {
  const auto side = [=](int point) { return point / (n * n) < n / 2; };
  return make_problem(
      make_lattice(n), [=](int a, int b) { return side(a) != side(b); }, nowhere);
}

RC_GTEST_PROP(KeptRows, ComplementIsThatOfADenseElimination, ()) {
  const Rods rods = *rc::gen::element(make_net(7, 5), make_lattice(4), make_protein(12, 4),
                                      Rods{9, {{0, 1}, {1, 2}, {2, 3}, {5, 6}}});
  const auto every = *rc::gen::inRange(1, 7).as("one row of so many is kept");
  const auto salt = *rc::gen::inRange(0, 1000);
  Problem problem = make_problem(
      rods, [&](int a, int b) { return (7 * a + 3 * b + salt) % every == 0; }, nowhere);
  for (std::size_t j = 0; j < problem.lower.size(); ++j)
    problem.values[static_cast<std::size_t>(problem.lower.start[j])] += 0.5;  // dependent rods of proteins need it
  Factor factor(problem);
  RC_ASSERT(factor.factorize().positive_definite);
  const Eigen::MatrixXd expected = dense_complement(problem), found = complement_of(factor);
  RC_ASSERT((expected.size() == 0 ? 0.0 : (found - expected).cwiseAbs().maxCoeff()) <= 1e-13);

  // The two halves of a solve are applied with the complement solved in between.
  const auto n = static_cast<Eigen::Index>(problem.lower.size()), g = static_cast<Eigen::Index>(problem.num_kept);
  Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
  const Eigen::VectorXd b = x;
  factor.eliminate(x.data());
  if (g > 0) x.tail(g) = found.llt().solve(x.tail(g)).eval();
  factor.substitute(x.data());
  RC_ASSERT((problem.dense() * x - b).cwiseAbs().maxCoeff() <= 1e-13);
}

/// The last front is in tiles, and the fronts below it are in tasks.
TEST(KeptRows, EveryNumberOfThreadsGivesTheSameBits) {
  for (const Problem& problem : {cut_net(60, 400), cut_lattice(19)}) {
    std::vector<double> triangle[2], x[2];
    for (const int threads : {1, 3}) {
      Factor factor(problem);
      ASSERT_TRUE(factor.factorize(threads).positive_definite);
      std::vector<double>& own = triangle[threads == 1 ? 0 : 1];
      own.resize(factor.complement_size());
      factor.write_complement(own.data());
      std::vector<double>& y = x[threads == 1 ? 0 : 1];
      for (std::size_t k = 0; k < problem.lower.size(); ++k) y.push_back(std::sin(static_cast<double>(k)));
      factor.eliminate(y.data(), threads);
      factor.substitute(y.data(), threads);
    }
    EXPECT_EQ(triangle[0], triangle[1]);
    EXPECT_EQ(x[0], x[1]);
  }
}

/// A part of a lattice between two cuts has more rods than freedoms. With the cut rods, whose other ends belong to
/// another part, S is singular. The sum of the parts' complements is not.
TEST(KeptRows, PartThatIsSingularWithItsCutRodsIsEliminated) {
  constexpr int n = 8, layers = 2;
  const auto part_of = [](int point) { return point / (n * n) / layers; };
  const auto is_cut = [&](int a, int b) { return part_of(a) != part_of(b); };
  const Rods whole = make_lattice(n);
  std::vector<std::pair<int, int>> cut;
  for (const auto& [a, b] : whole.ends)
    if (is_cut(a, b)) cut.emplace_back(a, b);
  Eigen::MatrixXd sum =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(cut.size()), static_cast<Eigen::Index>(cut.size()));
  bool is_some_singular = false;
  for (int part = 0; part < n / layers; ++part) {
    // Unit columns are taken rod by rod. A part lists all rods, and those of other parts are between massless points.
    const Problem problem = make_problem(whole, is_cut, [&](int point) { return part_of(point) != part; });
    Problem own = problem;
    for (std::size_t j = 0; j + own.num_kept < own.lower.size(); ++j) {
      double& diagonal = own.values[static_cast<std::size_t>(own.lower.start[j])];
      if (diagonal == 0.0) diagonal = 1.0;  // the diagonal of a rod of another part
    }
    Factor factor(own);
    ASSERT_TRUE(factor.factorize().positive_definite);
    const Eigen::MatrixXd C = complement_of(factor);
    sum += C;
    std::vector<Eigen::Index> touched;
    for (Eigen::Index k = 0; k < C.rows(); ++k)
      if (C(k, k) != 0.0) touched.push_back(k);
    const Eigen::MatrixXd rows = C(touched, touched);
    const Eigen::VectorXd values = rows.selfadjointView<Eigen::Lower>().eigenvalues();
    is_some_singular = is_some_singular || values.minCoeff() < 1e-12 * values.maxCoeff();
  }
  EXPECT_TRUE(is_some_singular);
  const Eigen::MatrixXd expected = dense_complement(make_problem(whole, is_cut, nowhere));
  EXPECT_LE((sum - expected).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_EQ(sum.llt().info(), Eigen::Success);
}

TEST(KeptRows, ColumnThatFailsIsNamed) {
  Problem problem = cut_net(20, 20);
  problem.values[static_cast<std::size_t>(problem.lower.start[11])] = -1.0;
  Factor factor(problem);
  const Cholesky::Quality quality = factor.factorize();
  EXPECT_FALSE(quality.positive_definite);
  EXPECT_EQ(quality.weakest_row, 11u);
}

}  // namespace
}  // namespace tanor
