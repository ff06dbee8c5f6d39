/// A step's calls in this room take no memory. Allocations are counted in operator new, which all containers use.

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <vector>

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include "evaluate/constraints.hpp"
#include "evaluate/forces.hpp"

namespace {
std::atomic<std::size_t> allocations{0};
}  // namespace

// These functions are not inlined, for the compiler would see malloc and free through new and delete, and warn.
[[gnu::noinline]] void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* block = std::malloc(size)) return block;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* block) noexcept {
  std::free(block);
}
[[gnu::noinline]] void operator delete(void* block, std::size_t) noexcept {
  std::free(block);
}

namespace tanor {
using namespace detail;
namespace {

/// Makes every kind of constraint and force on a zigzag long enough for several threads. Parameters that may move do
/// move.
System make_system() {
  constexpr Index n = 9000;
  const auto swinging = ScalarFunction::formula("1 + 0.1*sin(t)");
  System system;
  Rods rods{"", {}, {}, {}}, breathing{"", {}, swinging, {}};
  Planes planes{"", {}, VectorFunction(swinging, 1.0, 2.0), {}};
  Spheres spheres{"", {}, Vector3{0.0, -5.0, 0.0}, {}};
  Lines lines{"", {}, Vector3{}, VectorFunction(swinging, 1.0, 2.0)};
  Circles circles{"", {}, Vector3{0.0, -5.0, 0.0}, VectorFunction(swinging, 1.0, 2.0), {}};
  Angles angles{"", {}, {}};
  Pulleys pulleys{"", {}, {0.0, 9.0, 0.0}, {1.0, 9.0, 0.0}, {}, 2.0};
  Linears linears{"", {}, {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}}, swinging};
  ConstantForce wind{"", {}, VectorFunction(swinging, 0.0, 1.0)};
  UserConstraints user{
      "", {}, make_constraint_kernel<2>([](const auto& x, const auto& s) { return x[0] * x[5] + sin(s) * x[3]; })};
  UserConstraints formula{"", {}, formula_constraint("sqrt(x1^2 + y2^2 + 1) - exp(0.1*t)*z1^3", 2)};
  FormulaForce field{"", {}, formula_force({"sin(x)*t", "-vy^2", "z"})};
  Springs springs{"", {}, 5.0, 0.1, {}};
  Drag drag{"", {}, 0.1, 0.2};
  for (Index i = 0; i < n; ++i) {
    system.positions.insert(system.positions.end(), {0.1 * i, 0.05 * (i % 2), 0.01 * (i % 3)});
    for (auto* points :
         {&planes.points, &spheres.points, &lines.points, &circles.points, &wind.points, &drag.points, &field.points}) {
      points->push_back(i);
    }
    if (i < 2) continue;
    rods.pairs.push_back({i - 1, i});
    breathing.pairs.push_back({i - 2, i});
    springs.pairs.push_back({i, i - 2});
    angles.triples.push_back({i - 2, i - 1, i});
    pulleys.pairs.push_back({i - 1, i});
    linears.tuples.push_back({i - 1, i});
    user.tuples.push_back({i - 1, i});
    formula.tuples.push_back({i, i - 1});
  }
  system.masses.assign(n, 1.0);
  system.supports = {{"", {0, n - 1}, {}}};
  system.constraints = {rods, breathing, planes, spheres, lines, circles, angles, pulleys, linears, user, formula};
  system.forces = {Gravity{"", {0.0, 0.0, -9.81}}, wind, springs, drag, field};
  return system;
}

class Allocation : public testing::TestWithParam<int> {};

TEST_P(Allocation, ConstraintsAndForcesOfAStepTakeNoMemory) {
  const System system = make_system();
  const Numbering numbering = number(system);
  Constraints constraints(system, numbering);
  Forces forces(system, numbering);
  const Parallel parallel(GetParam());
  const double* const r = system.positions.data();
  std::vector<double> f(system.positions.size()), rows(constraints.num_rows()), blocks(3 * constraints.num_blocks());
  double sum = 0.0;
  const auto evaluate_all = [&](double t) {
    constraints.set_time(t);
    sum += constraints.evaluate_values(parallel, r, rows.data());
    sum += constraints.evaluate_rates(parallel, r, r, rows.data());
    constraints.evaluate_gradients(parallel, r, blocks.data());
    sum += constraints.evaluate_right_side(parallel, r, r, r, rows.data(), blocks.data());
    sum += constraints.apply_transposed(parallel, blocks.data(), r, nullptr, rows.data());
    forces.evaluate(parallel, t, r, r, f.data());
    sum += forces.potential(parallel, 0.0, r) + forces.power(parallel, r, r) +
           forces.elastic_power_of_supports(parallel, r, r);
  };
  evaluate_all(0.1);  // threads start

  const std::size_t before = allocations;
  evaluate_all(0.2);
  const std::size_t taken = allocations - before;

  EXPECT_EQ(taken, 0u);
  EXPECT_TRUE(std::isfinite(sum));
}

INSTANTIATE_TEST_SUITE_P(Evaluate, Allocation, testing::Values(1, 2));

TEST(AllocationCounter, SeesAVector) {
  const std::size_t before = allocations;

  const std::vector<double> vector(1000);

  EXPECT_EQ(vector[999], 0.0);
  EXPECT_EQ(allocations - before, 1u);
}

}  // namespace
}  // namespace tanor
