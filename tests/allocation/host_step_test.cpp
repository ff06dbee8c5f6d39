/// A step of a host with a Constrainer takes no memory.

#include <vector>

#include <gtest/gtest.h>
#include <tanor/constrainer.hpp>

#include "allocation/steady_steps.hpp"
#include "beside.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

using allocation::AllocationCounter;
using allocation::Scene;

/// Makes methane with all ten distances, one of which depends on the others.
System make_redundant() {
  System system;
  Rods rods{"rods", {}, {}, {}};
  const double a = 0.629;
  for (const auto& place : {Vector3{0, 0, 0}, {a, a, a}, {a, -a, -a}, {-a, a, -a}, {-a, -a, a}}) {
    const Index i = scenes::add_point(place, &system);
    for (Index j = 0; j < i; ++j) rods.pairs.push_back({j, i});
  }
  system.constraints = {rods};
  return system;
}

const Scene scenes_of_hosts[]{{"chain", [] { return scenes::make_chain(4'200); }},
                              {"ring", [] { return scenes::make_ring(260); }},
                              {"net", [] { return scenes::make_net(30, 30); }},
                              {"clusters", [] { return scenes::make_clusters(50); }},
                              {"beads", [] { return scenes::make_beads(1'100); }},
                              {"breathing_rods", [] { return scenes::make_breathing_chain(100); }},
                              {"mixture", [] { return allocation::make_mixture(scenes::make_chain(300)); }},
                              {"redundant", make_redundant}};

class HostStepTest : public testing::TestWithParam<std::tuple<Scene, int>> {};

TEST_P(HostStepTest, AllocatesNothing) {
  const auto& [scene, threads] = GetParam();
  const System system = scene.build();
  std::vector<double> masses = system.masses;
  for (const Support& support : system.supports) {
    for (const Index point : support.points) masses[static_cast<std::size_t>(point)] = 1.0 / 0.0;
  }
  Constrainer constrainer(masses, system.constraints, system.positions, {.threads = threads});
  const double h = 1e-3;
  std::vector<double> r = system.positions, old = r, v(r.size(), 0.0), f(r.size()), w(r.size()), eta(r.size());
  std::vector<double> lambda(constrainer.num_rows()), stress(3 * r.size());
  for (std::size_t k = 0; k < f.size(); ++k) f[k] = std::sin(1.0 + static_cast<double>(k));
  double t = 0.0;
  const auto step = [&] {
    for (std::size_t k = 0; k < r.size(); ++k) {
      const bool moves = masses[k / 3] < 1e300;
      old[k] = r[k];
      if (moves) v[k] += h * f[k];
      if (moves) r[k] += h * v[k];
    }
    t += h;
    return constrainer
               .constrain_positions({.step = h,
                                     .old_positions = old,
                                     .positions = r,
                                     .velocities = v,
                                     .wanted = {.multipliers = lambda, .forces = eta, .stress = stress},
                                     .time = t})
               .outcome.ok() &&
           constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v, .time = t}).outcome.ok() &&
           constrainer
               .solve({.positions = r,
                       .velocities = v,
                       .forces = f,
                       .accelerations = w,
                       .wanted = {.multipliers = lambda, .forces = eta},
                       .time = t})
               .outcome.ok() &&
           constrainer.project_forces(r, w, t).outcome.ok();
  };
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(step());

  const AllocationCounter counter;
  bool is_ok = true;
  for (int k = 0; k < 10; ++k) is_ok = step() && is_ok;
  const std::size_t count = counter.count();

  EXPECT_TRUE(is_ok);
  EXPECT_EQ(count, 0U);
}

INSTANTIATE_TEST_SUITE_P(Scenes, HostStepTest,
                         testing::Combine(testing::ValuesIn(scenes_of_hosts), testing::Values(1, 2)),
                         [](const auto& instance) {
                           return std::get<0>(instance.param).name + "_" + std::to_string(std::get<1>(instance.param));
                         });

}  // namespace
}  // namespace tanor
