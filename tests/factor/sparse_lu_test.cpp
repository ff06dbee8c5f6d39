#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <random>
#include <vector>

#include "base/parallel.hpp"
#include "factor/sparse_lu.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Makes a pattern of up to five numbers a column besides the diagonal, in random rows.
SquarePattern make_pattern(int n) {
  std::mt19937 random(7);
  SquarePattern pattern;
  for (int j = 0; j < n; ++j) {
    std::vector<int> rows{j};
    for (int k = 0; k < 5; ++k) rows.push_back(static_cast<int>(random() % static_cast<unsigned>(n)));
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    pattern.rows.insert(pattern.rows.end(), rows.begin(), rows.end());
    pattern.start.push_back(static_cast<int>(pattern.rows.size()));
  }
  return pattern;
}

template <class T>
T make_number(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  if constexpr (std::is_same_v<T, double>)
    return uniform(random);
  else
    return {uniform(random), uniform(random)};
}

/// Returns |A x - b| with x = A^-1 b.
template <class T>
double measure_residual(SparseLu<T>& lu, const std::vector<T>& b) {
  std::vector<T> x = b, rest = b;
  lu.solve(x.data());
  const SquarePattern& pattern = lu.pattern();
  for (std::size_t j = 0; j < pattern.size(); ++j) {
    for (int k = pattern.start[j]; k < pattern.start[j + 1]; ++k) rest[pattern.rows[k]] -= lu.values()[k] * x[j];
  }
  double worst = 0.0;
  for (const T& number : rest) worst = larger(worst, std::abs(number));
  return worst;
}

template <class T>
class SparseLuTest : public ::testing::Test {};
using Scalars = ::testing::Types<double, std::complex<double>>;
TYPED_TEST_SUITE(SparseLuTest, Scalars);

TYPED_TEST(SparseLuTest, SolvesAndKeepsItsPivotsWhileTheyServe) {
  const int n = 200;
  std::mt19937 random(1);
  SparseLu<TypeParam> lu(make_pattern(n));
  const std::size_t entries = lu.pattern().rows.size();
  for (std::size_t k = 0; k < entries; ++k) lu.values()[k] = make_number<TypeParam>(random);
  std::vector<TypeParam> b(n);
  for (TypeParam& number : b) number = make_number<TypeParam>(random);
  for (int time = 0; time < 3; ++time) {
    ASSERT_TRUE(lu.factorize());
    EXPECT_LT(measure_residual(lu, b), 1e-10);
    for (std::size_t k = 0; k < entries; ++k) lu.values()[k] *= 1.01;
  }
  EXPECT_EQ(lu.num_pivotings(), 1u);
}

TYPED_TEST(SparseLuTest, PivotsThatVanishAreChosenAnew) {
  // The matrix is [a 1; 1 b] with a = 1 and 1e-14 and b = 1e-3, and then with a = b = 0.
  SparseLu<TypeParam> lu({{0, 2, 4}, {0, 1, 0, 1}});
  const std::vector<TypeParam> b{2.0, 3.0};
  for (const double a : {1.0, 1e-14, 0.0}) {
    const std::vector<TypeParam> values{a, 1.0, 1.0, a == 0.0 ? 0.0 : 1e-3};
    std::copy(values.begin(), values.end(), lu.values());
    ASSERT_TRUE(lu.factorize()) << a;
    EXPECT_LT(measure_residual(lu, b), 1e-14) << a;
  }
}

TYPED_TEST(SparseLuTest, ASingularMatrixOrOneWithoutNumbersHasNoFactor) {
  SparseLu<TypeParam> lu({{0, 2, 4}, {0, 1, 0, 1}});
  std::fill(lu.values(), lu.values() + 4, TypeParam(1.0));
  EXPECT_FALSE(lu.factorize());
  std::fill(lu.values(), lu.values() + 4, TypeParam(std::nan("")));
  EXPECT_FALSE(lu.factorize());
}

}  // namespace
}  // namespace tanor
