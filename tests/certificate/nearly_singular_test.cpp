/// \file Where K nearly loses rank, S has no Cholesky factor, and the certificate reports that it has no digits to
/// spare.

#include <gtest/gtest.h>

#include "certificate/certified.hpp"

namespace tanor {
namespace {

/// Makes two chains of four rods from a support to one bead, which are about 4 `width` apart. If `width` is 0, their
/// rods depend on each other.
System make_double_chain(double width) {
  constexpr int links = 4;
  System system;
  Rods rods{.name = "rods"};
  system.positions = {0.0, 0.0, 0.0};
  Index next = 1;
  const Index bead = 2 * (links - 1) + 1;
  for (const double side : {-0.7, 1.0}) {
    Index last = 0;
    for (int k = 1; k < links; ++k) {
      system.positions.insert(system.positions.end(), {side * width * k * (links - k), 0.0, -1.0 * k});
      rods.pairs.push_back({last, next});
      last = next++;
    }
    rods.pairs.push_back({last, bead});
  }
  system.positions.insert(system.positions.end(), {0.0, 0.0, -1.0 * links});
  system.masses.assign(system.positions.size() / 3, 1.0);
  system.supports.push_back({"", {0}, {}});
  system.constraints = {rods};
  system.add_gravity({1.0, 0.0, -9.81});
  return system;
}

TEST(NearlySingular, ChainsSideBySideHaveTheConditionOfTheirDistance) {
  for (const double width : {1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-5}) {
    const Certificate certificate = Case(make_double_chain(width)).certify();

    EXPECT_LE(certificate.reciprocal_condition, 1e2 * width * width) << width;
    EXPECT_TRUE(certificate.passed()) << width << " " << certificate.line();
  }
}

}  // namespace
}  // namespace tanor
