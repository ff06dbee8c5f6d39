#include "statics/deflated.hpp"

#include <Spectra/SymEigsSolver.h>
#include <Eigen/Dense>

#include <gtest/gtest.h>

namespace tanor {
using namespace detail;
namespace {

/// Returns the three largest eigenvalues of a diagonal matrix, as Lanczos' method finds them from the start for it.
Eigen::VectorXd find_three(const Eigen::VectorXd& diagonal) {
  const Eigen::MatrixXd nothing(diagonal.size(), 0);
  double unit = 1.0;
  Deflated operation(nothing, [&](const double* from, double* to) {
    Eigen::Map<Eigen::VectorXd>(to, diagonal.size()) =
        diagonal.cwiseProduct(Eigen::Map<const Eigen::VectorXd>(from, diagonal.size())) / unit;
  });
  const Eigen::VectorXd any = Eigen::VectorXd::LinSpaced(diagonal.size(), 0.3, 1.7),
                        start = find_start(operation, any, &unit);
  Spectra::SymEigsSolver lanczos(operation, 3, 12);
  lanczos.init(start.data());
  const Eigen::Index found = lanczos.compute(Spectra::SortRule::LargestAlge, 1000, 1e-12);
  return unit * lanczos.eigenvalues().head(found);
}

/// Spectra answers with rounding that it has blown up where it starts elsewhere.
TEST(FindStart, ServesWhereAllEigenvaluesAreEqual) {
  for (const Eigen::Index size : {40, 400}) {
    for (const double value : {1e-9, 3.0, 1e9, 1e20}) {
      const Eigen::VectorXd found = find_three(Eigen::VectorXd::Constant(size, value));
      ASSERT_GT(found.size(), 0) << value;
      EXPECT_LT((found.array() - value).abs().maxCoeff(), 1e-12 * value) << size;
    }
  }
}

/// The others are found to the rounding of the largest one.
TEST(FindStart, ServesWhereOneEigenvalueIsFarLargerThanTheRest) {
  for (const Eigen::Index size : {40, 400}) {
    Eigen::VectorXd diagonal = Eigen::VectorXd::LinSpaced(size, 1.0, 2.0);
    diagonal[7] = 1e12;
    const Eigen::VectorXd found = find_three(diagonal);
    ASSERT_EQ(found.size(), 3);
    for (const Eigen::Index k : {0, 1, 2}) EXPECT_NEAR(found[k], k == 0 ? 1e12 : diagonal[size - k], 1.0);
  }
}

}  // namespace
}  // namespace tanor
