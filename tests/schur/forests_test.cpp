/// Forests that grow at random, cut into pieces for the lanes, are compared with a dense factor of many digits.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include <Eigen/Dense>

#include "schur/answers.hpp"
#include "schur/solver_at_place.hpp"

namespace tanor {
namespace {

struct Forest {
  std::vector<int> sizes;         ///< rods of each tree
  int most_back = 1 << 30;        ///< a point joins one of so many before it
  int supports = 0;               ///< leaves of each tree that are held
  double digits_of_masses = 1.0;  ///< masses between 1 and 10 to this power
  bool with_offsets = false;
};

/// Makes the trees with points and rods in any order.
System grow(const Forest& forest, AnyNumbers* any) {
  const auto count =
      static_cast<std::size_t>(std::accumulate(forest.sizes.begin(), forest.sizes.end(), 0)) + forest.sizes.size();
  std::vector<Index> place(count);
  std::iota(place.begin(), place.end(), 0);
  std::shuffle(place.begin(), place.end(), any->generator());
  System system;
  for (std::size_t k = 0; k < count; ++k)
    (void)add_point({3.0 * (*any)(), 3.0 * (*any)(), 3.0 * (*any)()}, any, &system);
  for (double& mass : system.masses) mass = std::pow(10.0, 0.5 * forest.digits_of_masses * (1.0 + (*any)()));
  Rods rods{"rods", {}, {}, {}};
  std::size_t first = 0;
  for (const int size : forest.sizes) {
    for (int k = 1; k <= size; ++k) {
      const int parent = std::max(0, k - forest.most_back) + any->up_to(std::min(k, forest.most_back) - 1);
      const Index i = place[first + static_cast<std::size_t>(parent)], j = place[first + static_cast<std::size_t>(k)];
      rods.pairs.push_back(any->up_to(1) == 0 ? std::array{i, j} : std::array{j, i});
      if (k <= size - forest.supports || k < 2) continue;
      system.supports.push_back({"", {j}, VectorFunction(0.0, 0.0, 0.0)});
      std::fill_n(system.velocities.begin() + 3 * j, 3, 0.0);
      if (parent > size - forest.supports) rods.pairs.pop_back();  // no rod joins supports alone
    }
    first += static_cast<std::size_t>(size) + 1;
  }
  std::shuffle(rods.pairs.begin(), rods.pairs.end(), any->generator());
  for (std::size_t k = 0; forest.with_offsets && k < rods.pairs.size(); ++k)
    rods.offsets.push_back(k % 3 == 0 ? Vector3{1.0, -2.0, 0.5} : Vector3{});
  system.constraints = {rods};
  system.forces = {Gravity{"", {0.1, 0.0, -9.81}}};
  return system;
}

/// Returns the largest error of lambda = -S^-1 b, as numbers with which S has a unit diagonal, over its largest number
/// and over eps cond S of that scale.
double error_over_condition(const System& system, AnyNumbers* any) {
  using Precise = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
  SolverAtPlace at(system, LinearSolver::Trees);
  const auto num_rows = static_cast<Eigen::Index>(at.model.num_rows());
  std::vector<double> blocks(3 * at.work.constraints.num_blocks()), b(at.model.num_rows()), x(b);
  for (double& each : b) each = (*any)();
  EXPECT_GT(at.solver.linearise(at.model.parallel, at.r.data(), nullptr, blocks.data()).reciprocal_condition, 0.0);
  at.solver.solve_negative(at.model.parallel, b.data(), x.data());

  Precise root = Precise::Zero(static_cast<Eigen::Index>(at.r.size()), num_rows);  // M^-1/2 K
  for (const Incidence& each : at.model.incidences) {
    const double inverse_mass = at.model.inverse_mass[static_cast<std::size_t>(each.point)];
    for (Eigen::Index c = 0; c < 3; ++c)
      root(3 * each.point + c, each.row) =
          std::sqrt(static_cast<long double>(inverse_mass)) *
          static_cast<long double>(each.sign * blocks[static_cast<std::size_t>(3 * each.block + c)]);
  }
  const Precise lengths = root.colwise().norm();
  for (Eigen::Index a = 0; a < num_rows; ++a) root.col(a) /= lengths(a);
  const Precise S = root.transpose() * root;
  Precise right_side(num_rows, 1), found(num_rows, 1);
  for (Eigen::Index a = 0; a < num_rows; ++a) {
    right_side(a) = -static_cast<long double>(b[static_cast<std::size_t>(a)]) / lengths(a);
    found(a) = static_cast<long double>(x[static_cast<std::size_t>(a)]) * lengths(a);
  }
  const Precise exact = S.llt().solve(right_side);
  const Eigen::VectorXd spectrum = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S.cast<double>()).eigenvalues();
  const double condition = spectrum(num_rows - 1) / std::max(spectrum(0), 1e-16);
  const auto error = static_cast<double>((found - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff());
  return error / (std::numeric_limits<double>::epsilon() * condition);
}

TEST(Forests, AgreeWithADenseFactor) {
  AnyNumbers any(41);
  for (const std::vector<int>& sizes : {std::vector{1}, {2, 1}, {5, 3, 8}, {40}, {150}, {60, 20, 7, 60, 3, 90}}) {
    for (const int most_back : {1, 2, 6, 1 << 30}) {
      for (const int supports : {0, 1, 3}) {
        for (const double digits : {0.0, 3.0, 12.0}) {
          SCOPED_TRACE(testing::Message() << sizes.size() << " trees, the first of " << sizes[0] << " rods, back "
                                          << most_back << ", " << supports << " supports, digits " << digits);
          if (supports > 0 && sizes.back() < 8) continue;
          EXPECT_LE(error_over_condition(grow({sizes, most_back, supports, digits, supports == 1}, &any), &any), 4.0);
        }
      }
    }
  }
}

/// A star has one point at which all pieces end, one after the other.
TEST(Forests, StarsAgreeWithADenseFactor) {
  AnyNumbers any(42);
  System star = grow({{150}, 1 << 30, 0, 1.0, false}, &any);
  auto& pairs = std::get<Rods>(star.constraints[0]).pairs;
  for (std::size_t k = 0; k < pairs.size(); ++k) pairs[k] = {0, static_cast<Index>(k + 1)};
  EXPECT_LE(error_over_condition(star, &any), 4.0);
}

TEST(Forests, AgreeWithTheGeneralSolver) {
  AnyNumbers any(43);
  for (const Forest& forest : {Forest{{3000}, 1 << 30, 2, 1.0, false}, Forest{{2000, 900, 40, 5}, 100, 0, 1.0, true},
                               Forest{std::vector<int>(300, 23), 1 << 30, 1, 1.0, false}}) {
    const System system = grow(forest, &any);
    const Answer general = solve(system, {.linear_solver = LinearSolver::General}, 0.2),
                 trees = solve(system, {.linear_solver = LinearSolver::Trees}, 0.2);
    ASSERT_TRUE(trees.report.outcome.ok()) << trees.report.outcome.what;
    EXPECT_LE(trees.report.residual, rounding);
    EXPECT_LE(relative_difference(trees.w, general.w), rounding);
    EXPECT_LE(relative_difference(trees.lambda, general.lambda), rounding);
  }
}

TEST(Forests, GiveTheSameBitsOnAnyThreads) {
  AnyNumbers any(44);
  const System one = grow({{30000}, 100, 1, 1.0, false}, &any),
               many = grow({std::vector<int>(900, 31), 1 << 30, 1, 1.0, true}, &any);
  for (const System& system : {one, many}) {
    const Answer alone = solve(system, {.linear_solver = LinearSolver::Trees, .threads = 1});
    for (const int threads : {2, 3, 4}) {
      const Answer together = solve(system, {.linear_solver = LinearSolver::Trees, .threads = threads});
      EXPECT_EQ(together.w, alone.w) << threads;
      EXPECT_EQ(together.lambda, alone.lambda) << threads;
    }
  }
}

/// Trees share lanes and groups; those without bad numbers do not see them.
TEST(Forests, ANumberThatIsNoneStaysInItsTree) {
  AnyNumbers any(45);
  SolverAtPlace at(grow({{9, 30, 17, 30, 12, 44, 3, 30, 25, 17}, 1 << 30, 0, 1.0, false}, &any), LinearSolver::Trees);
  const Model& model = at.model;
  const auto solve_at = [&](const std::vector<double>& r) {
    std::vector<double> blocks(3 * at.work.constraints.num_blocks()), scratch(model.num_rows()), lambda(scratch),
        w(r.size());
    const Vec3 uniform{0.1, 0.0, -9.81};
    const Elimination found =
        at.solver.solve(model.parallel, {.r = r.data(), .v = at.v.data(), .w0 = w.data(), .uniform = &uniform},
                        FactorUse::Renew, blocks.data(), scratch.data(), lambda.data(), w.data());
    return std::pair(lambda, found);
  };
  const auto [good, found_good] = solve_at(at.r);
  EXPECT_TRUE(std::isfinite(found_good.residual));
  for (std::size_t island = 0; island < model.numbering.num_islands(); ++island) {
    std::vector<double> r = at.r;
    const auto first = static_cast<std::size_t>(model.numbering.island_start[island]),
               end = static_cast<std::size_t>(model.numbering.island_start[island + 1]);
    const auto bad = std::ranges::find_if(
        model.incidences, [&](const Incidence& each) { return static_cast<std::size_t>(each.row) == first; });
    r[3 * static_cast<std::size_t>(bad->point)] = std::numeric_limits<double>::quiet_NaN();
    const auto [lambda, found] = solve_at(r);
    EXPECT_TRUE(std::isnan(found.largest_right_side));
    for (std::size_t row = 0; row < good.size(); ++row) {
      if (row < first || row >= end) {
        EXPECT_EQ(lambda[row], good[row]) << island;
      }
    }
  }
}

}  // namespace
}  // namespace tanor
