/// A step of a host with a Constrainer takes no memory.

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
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

/// How a host calls: with packed arrays, with points in another order, in a cell that changes in every step, or after
/// edits.
enum class Way { Packed, Indexed, Cell, Edited };
const char* const way_names[]{"packed", "indexed", "cell", "edited"};

/// A host with its arrays. Point i of the system stands at place[i] in them.
struct Caller {
  std::vector<double> masses;
  std::vector<Index> place;
  PeriodicCell cell{{Vector3{1e4, 0, 0}, {10, 2e4, 0}, {0, 30, 3e4}}};
  std::vector<double> r, old, v, f, w, eta, stress, lambda;
  std::optional<Constrainer> constrainer;
  Way way;
  double t = 0.0;

  Caller(const System& system, Way how, int threads)
      : masses(system.num_points()), place(system.num_points()), r(system.positions), way(how) {
    const std::size_t n = system.num_points();
    std::vector<double> masses_of_system = system.masses;
    for (const Support& support : system.supports) {
      for (const Index point : support.points)
        masses_of_system[static_cast<std::size_t>(point)] = std::numeric_limits<double>::infinity();
    }
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t there = way == Way::Indexed ? n - 1 - i : i;
      place[i] = static_cast<Index>(there);
      masses[there] = masses_of_system[i];
      std::copy_n(&system.positions[3 * i], 3, &r[3 * there]);
    }
    if (way == Way::Cell)
      constrainer.emplace(masses_of_system, system.constraints, array(r), Periodicity{cell, {}},
                          SolverOptions{.threads = threads});
    else
      constrainer.emplace(masses_of_system, system.constraints, array(r), SolverOptions{.threads = threads});
    if (way == Way::Edited) {
      constrainer->expect_edits();
      constrainer->remove(std::array<ConstraintId, 1>{0});
    }
    for (std::vector<double>* each : {&v, &f, &w, &eta}) each->resize(r.size(), 0.0);
    old = r;
    stress.resize(3 * r.size());
    lambda.resize(constrainer->num_rows());
    for (std::size_t k = 0; k < f.size(); ++k) f[k] = std::sin(1.0 + static_cast<double>(k));
  }
  PointArray array(std::vector<double>& from) const {
    return PointArray(from.data(), 0, way == Way::Indexed ? place.data() : nullptr);
  }
  ConstPointArray array(const std::vector<double>& from) const {
    return ConstPointArray(from.data(), 0, way == Way::Indexed ? place.data() : nullptr);
  }

  bool step() {
    constexpr double h = 1e-3;
    for (std::size_t k = 0; k < r.size(); ++k) {
      const bool moves = std::isfinite(masses[k / 3]);
      old[k] = r[k];
      if (moves) v[k] += h * f[k];
      if (moves) r[k] += h * v[k];
    }
    t += h;
    if (way == Way::Cell) {
      for (Vector3& edge : cell.edges) edge[0] *= 1.0 + 1e-9;
      constrainer->set_cell(cell);
    }
    return constrainer
               ->constrain_positions({.step = h,
                                      .old_positions = array(std::as_const(old)),
                                      .positions = array(r),
                                      .velocities = array(v),
                                      .wanted = {.multipliers = lambda, .forces = array(eta), .stress = array(stress)},
                                      .time = t})
               .outcome.ok() &&
           constrainer
               ->constrain_velocities(
                   {.step = h, .positions = array(std::as_const(r)), .velocities = array(v), .time = t})
               .outcome.ok() &&
           constrainer
               ->solve({.positions = array(std::as_const(r)),
                        .velocities = array(std::as_const(v)),
                        .forces = array(std::as_const(f)),
                        .accelerations = array(w),
                        .wanted = {.multipliers = lambda, .forces = array(eta)},
                        .time = t})
               .outcome.ok() &&
           constrainer->project_forces(array(std::as_const(r)), array(w), t, {.multipliers = lambda}).outcome.ok();
  }
};

class HostStepTest : public testing::TestWithParam<std::tuple<Scene, int, Way>> {};

TEST_P(HostStepTest, AllocatesNothing) {
  const auto& [scene, threads, way] = GetParam();
  Caller caller(scene.build(), way, threads);
  for (int k = 0; k < 3; ++k) ASSERT_TRUE(caller.step());

  const AllocationCounter counter;
  bool is_ok = true;
  for (int k = 0; k < 10; ++k) is_ok = caller.step() && is_ok;
  const std::size_t count = counter.count();

  EXPECT_TRUE(is_ok);
  EXPECT_EQ(count, 0U);
}

INSTANTIATE_TEST_SUITE_P(Scenes, HostStepTest,
                         testing::Combine(testing::ValuesIn(scenes_of_hosts), testing::Values(1, 2),
                                          testing::Values(Way::Packed, Way::Indexed, Way::Cell, Way::Edited)),
                         [](const auto& instance) {
                           return std::get<0>(instance.param).name + "_" + std::to_string(std::get<1>(instance.param)) +
                                  "_" + way_names[static_cast<std::size_t>(std::get<2>(instance.param))];
                         });

/// The cell changes in every step, and with it the offset of the rod that closes the ring round the cell.
TEST(HostStep, AllocatesNothingWhereRodsCloseAWayRoundTheCell) {
  const std::vector<double> masses{1.0, 2.0, 1.5, 1.0};
  const std::vector<double> start{0.5, 0.1, 0, 1.5, 0.6, 0.2, 2.5, 0.2, 0.4, 3.5, 0.7, 0.1};
  for (const LinearSolver solver : {LinearSolver::General, LinearSolver::Paths, LinearSolver::Batches}) {
    PeriodicCell cell{{Vector3{4, 0, 0}, {0.3, 5, 0}, {0, 0.2, 5}}};
    Constrainer constrainer(masses, {Rods{"ring", {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, {}, {}}}, start,
                            Periodicity{cell, {}}, SolverOptions{.linear_solver = solver, .threads = 1});
    std::vector<double> r = start, old = start, v(r.size(), 0.01);
    ASSERT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome.ok());  // in the first cell
    const auto step = [&] {
      old = r;
      for (std::size_t k = 0; k < r.size(); ++k) r[k] += 1e-3 * v[k];
      cell.edges[0][0] *= 1.0 - 1e-5;
      constrainer.set_cell(cell);
      return constrainer.constrain_positions({.step = 1e-3, .old_positions = old, .positions = r, .velocities = v})
                 .outcome.ok() &&
             constrainer.constrain_velocities({.step = 1e-3, .positions = r, .velocities = v}).outcome.ok();
    };
    for (int k = 0; k < 3; ++k) ASSERT_TRUE(step());

    const AllocationCounter counter;
    bool is_ok = true;
    for (int k = 0; k < 10; ++k) is_ok = step() && is_ok;
    const std::size_t count = counter.count();

    EXPECT_TRUE(is_ok);
    EXPECT_EQ(count, 0U) << static_cast<int>(solver);
  }
}

}  // namespace
}  // namespace tanor
