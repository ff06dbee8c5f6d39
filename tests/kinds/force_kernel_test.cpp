/// The definition of a kind of force as a kernel, on which new kinds run, is compared with the loops of drag.

#include "kinds/force_kernel.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "evaluate/forces.hpp"

namespace tanor {
using namespace detail;
namespace {

System dragged_points(const Force& force) {
  System system;
  system.positions = {0, 0, 0, 1, 2, 3, -1, 0, 2};
  system.masses = {1, 2, 3};
  system.forces = {force};
  return system;
}

std::vector<double> evaluate(const System& system, const std::vector<double>& v) {
  Forces forces(system, number(system));
  std::vector<double> f(9);
  forces.evaluate(Parallel(1), 0.0, system.positions.data(), v.data(), f.data());
  return f;
}

TEST(ForceKernel, DefinitionOfDragIsWhatItsLoopComputes) {
  const Drag drag{"", {0, 2}, 0.3, 0.7};
  const std::vector<double> v{1, -2, 0.5, 3, 1, 1, 0, 0.25, -4};

  const auto by_loop = evaluate(dragged_points(drag), v);
  const auto by_kernel = evaluate(dragged_points(FormulaForce{"", {0, 2}, kernel_of_definition(drag)}), v);

  EXPECT_EQ(by_kernel, by_loop);
  EXPECT_NE(by_loop[0], 0.0);
}

/// The derivative is d f/dv = -(c1 + c2 |v|) I - c2 v v'/|v|.
TEST(ForceKernel, DefinitionHasDerivatives) {
  const ForceKernel kernel = kernel_of_definition(Drag{"", {0}, 0.3, 0.7});
  const std::array<double, 3> r{}, v{0, 3, 4};
  std::array<double, 3> f{};
  std::array<double, 18> derivative{};

  kernel.evaluate(kernel.context.get(), {1, 0.0, r.data(), v.data(), f.data(), derivative.data()});

  EXPECT_NEAR(f[1], -(0.3 + 0.7 * 5.0) * 3.0, 1e-14);
  EXPECT_NEAR(derivative[6 * 1 + 4], -(0.3 + 0.7 * 5.0) - 0.7 * 9.0 / 5.0, 1e-14);
  EXPECT_NEAR(derivative[6 * 1 + 5], -0.7 * 12.0 / 5.0, 1e-14);
  EXPECT_TRUE(kernel.depends_on_velocity);
}

}  // namespace
}  // namespace tanor
