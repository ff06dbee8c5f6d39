/// Runge-Kutta coefficients satisfy the order conditions of all rooted trees (Hairer, Norsett, Wanner I, II.2).

#include <cmath>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "base/parallel.hpp"
#include "motion/composition.hpp"
#include "motion/runge_kutta.hpp"

namespace tanor {
using namespace detail;
namespace {

using Row = std::vector<double>;

/// A rooted tree, described by what its condition needs: sum_j weight_j elementary_j = 1/density.
struct Tree {
  int order;
  double density;
  Row elementary;
};

/// Returns all stages of a method: its own, the one at the new point, those of the dense output.
std::vector<Row> list_rows(const Tableau& tableau) {
  std::vector<Row> rows = tableau.a;
  rows.push_back(tableau.b);
  rows.insert(rows.end(), tableau.dense.a.begin(), tableau.dense.a.end());
  return rows;
}

Row multiply(const std::vector<Row>& a, const Row& y) {
  Row result(a.size(), 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t j = 0; j < a[i].size(); ++j) result[i] += a[i][j] * y[j];
  }
  return result;
}

/// Returns every tree of at most this order, as a root with a multiset of smaller trees on it.
std::vector<Tree> list_trees(const std::vector<Row>& a, int most) {
  std::vector<Tree> trees;
  std::vector<Row> on_stage;  // A times elementary
  for (int order = 1; order <= most; ++order) {
    const std::size_t smaller = trees.size();
    const std::function<void(Tree, int, std::size_t)> grow = [&](Tree tree, int left, std::size_t last) {
      if (left == 0) {
        tree.density *= order;
        trees.push_back(tree);
        return;
      }
      for (std::size_t k = 0; k <= last && k < smaller; ++k) {
        if (trees[k].order > left) break;
        Tree next{order, tree.density * trees[k].density, tree.elementary};
        for (std::size_t i = 0; i < a.size(); ++i) next.elementary[i] *= on_stage[k][i];
        grow(next, left - trees[k].order, k);
      }
    };
    grow({order, 1.0, Row(a.size(), 1.0)}, order - 1, smaller);
    for (std::size_t k = smaller; k < trees.size(); ++k) on_stage.push_back(multiply(a, trees[k].elementary));
  }
  return trees;
}

double dot(const Row& weights, const Row& values) {
  double sum = 0.0;
  for (std::size_t j = 0; j < weights.size(); ++j) sum += weights[j] * values[j];
  return sum;
}

/// Returns the largest defect of the conditions of the trees whose orders are `from` to `to`.
double largest_defect(const std::vector<Tree>& trees, const Row& weights, int from, int to, double right_side = 1.0) {
  double worst = 0.0;
  for (const Tree& tree : trees) {
    if (tree.order >= from && tree.order <= to)
      worst = larger(worst, std::abs(dot(weights, tree.elementary) - right_side / tree.density));
  }
  return worst;
}

struct Case {
  std::string name;
  Tableau tableau;
  int estimate_order, estimate3_order;  // the orders up to which e and e3 see nothing, or 0 if there is none

  friend std::ostream& operator<<(std::ostream& out, const Case& one) { return out << one.name; }
};

class TableauTest : public testing::TestWithParam<Case> {};

TEST_P(TableauTest, StagesStandWhereTheirRowsPutThem) {
  const Tableau& tableau = GetParam().tableau;
  const auto check = [](const Row& c, const std::vector<Row>& a) {
    ASSERT_EQ(c.size(), a.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
      double sum = 0.0;
      for (const double x : a[i]) sum += x;
      EXPECT_NEAR(sum, c[i], 2e-14) << i;
    }
  };
  check(tableau.c, tableau.a);
  check(tableau.dense.c, tableau.dense.a);
}

TEST_P(TableauTest, SatisfiesTheConditionsOfItsOrderAndNoHigherOne) {
  const Tableau& tableau = GetParam().tableau;
  const std::vector<Tree> trees = list_trees(list_rows(tableau), tableau.order + 1);

  EXPECT_LT(largest_defect(trees, tableau.b, 1, tableau.order), 1e-14);
  EXPECT_GT(largest_defect(trees, tableau.b, tableau.order + 1, tableau.order + 1), 1e-8);
}

TEST_P(TableauTest, EstimatesHaveTheirOrders) {
  const Tableau& tableau = GetParam().tableau;
  const std::vector<Tree> trees = list_trees(list_rows(tableau), 6);
  const auto check = [&](const Row& e, int order) {
    ASSERT_EQ(e.empty(), order == 0);
    if (e.empty()) return;
    EXPECT_LT(largest_defect(trees, e, 1, order, 0.0), 1e-14);
    EXPECT_GT(largest_defect(trees, e, order + 1, order + 1, 0.0), 1e-6);
  };
  check(tableau.e, GetParam().estimate_order);
  check(tableau.e3, GetParam().estimate3_order);
}

INSTANTIATE_TEST_SUITE_P(Methods, TableauTest,
                         testing::Values(Case{"rk4", rk4_tableau(), 0, 0}, Case{"dopri5", dopri5_tableau(), 4, 0},
                                         Case{"dop853", dop853_tableau(), 5, 3}),
                         [](const auto& instance) { return instance.param.name; });

TEST(TableauTest, ThereAreTwoHundredTreesUpToOrderEight) {
  EXPECT_EQ(list_trees(list_rows(dop853_tableau()), 8).size(), 200U);
}

/// The weights of y(s) = y0 + h sum_j weights_j y'_j are those of the interpolation, whose order is 7 inside the step.
TEST(TableauTest, DenseOutputOfDop853HasOrderSevenInsideTheStep) {
  const Tableau tableau = dop853_tableau();
  const std::vector<Tree> trees = list_trees(list_rows(tableau), 8);
  for (const double s : {0.1, 0.37, 0.5, 0.83}) {
    const double r = 1.0 - s, q = s * s * (3.0 - 2.0 * s);
    Row weights(16, 0.0);
    for (std::size_t j = 0; j < 12; ++j) weights[j] = q * tableau.b[j];
    weights[0] += s * r * r;
    weights[12] -= s * s * r;
    const std::array<double, 4> p{s * s * r * r, s * s * s * r * r, s * s * s * r * r * r, s * s * s * s * r * r * r};
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = 0; j < 16; ++j) weights[j] += p[i] * tableau.dense.d[i][j];
    }
    for (int order = 1; order <= 7; ++order) {
      EXPECT_LT(largest_defect(trees, weights, order, order, std::pow(s, order)), 2e-14) << "order " << order;
    }
    EXPECT_GT(largest_defect(trees, weights, 8, 8, std::pow(s, 8)), 1e-8);
  }
}

/// In symmetric compositions of a symmetric method (Hairer, Lubich, Wanner, V.3.1) odd powers vanish one by one.
TEST(CompositionTest, FractionsAreSymmetricAndCancelOddPowers) {
  const auto sum = [](std::span<const double> fractions, int power) {
    double result = 0.0;
    for (const double x : fractions) result += std::pow(x, power);
    return result;
  };
  for (const auto& [fractions, order] : {std::pair{suzuki_fractions(), 4}, std::pair{kahan_li_fractions(), 6}}) {
    EXPECT_NEAR(sum(fractions, 1), 1.0, 1e-15);
    for (int power = 3; power < order; power += 2) EXPECT_NEAR(sum(fractions, power), 0.0, 2e-16) << order;
    EXPECT_GT(std::abs(sum(fractions, order + 1)), 1e-3);
    for (std::size_t k = 0; k < fractions.size(); ++k) EXPECT_EQ(fractions[k], fractions[fractions.size() - 1 - k]);
  }
}

}  // namespace
}  // namespace tanor
