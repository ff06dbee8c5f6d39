#include <gtest/gtest.h>

#include <random>

#include "statics/tall_products.hpp"

namespace tanor {
using namespace detail;
namespace {

using Eigen::Index, Eigen::MatrixXd;

/// Sizes lie around the eight lanes, the four columns of a tile and the 512 rows of a part, and blocks are of wider
/// matrices, whose columns stand further apart.
TEST(TallProducts, AgreeWithEigen) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  const auto any = [&](Index rows, Index columns) {
    return MatrixXd(MatrixXd::NullaryExpr(rows, columns, [&] { return normal(random); }));
  };
  for (const Index rows : {0, 1, 7, 8, 9, 511, 512, 513, 1030}) {
    for (const Index a : {0, 1, 3, 4, 5, 9}) {
      for (const Index b : {1, 2, 4, 6}) {
        const MatrixXd wide = any(rows + 3, a + 2), B = any(rows, b), C = any(a, b);
        const auto A = wide.block(2, 1, rows, a);
        const double allowed = 1e-14 * static_cast<double>(rows + 10);
        MatrixXd rest = B;
        subtract_product(A, C, &rest);

        EXPECT_TRUE((multiply_transposed(A, B) - A.transpose() * B).isZero(allowed)) << rows << ' ' << a << ' ' << b;
        EXPECT_TRUE((multiply_tall(A, C) - A * C).isZero(1e-13)) << rows << ' ' << a << ' ' << b;
        EXPECT_TRUE((rest - (B - A * C)).isZero(1e-13)) << rows << ' ' << a << ' ' << b;
      }
    }
  }
}

}  // namespace
}  // namespace tanor
