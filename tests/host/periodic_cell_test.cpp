/// The tests compare rods in a periodic cell with the same rods where nothing is wrapped.

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "errors.hpp"
#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

using Edges = std::array<Vector3, 3>;

/// Returns r wrapped into the cell along the edges that repeat.
std::vector<double> wrap(const PeriodicCell& cell, std::vector<double> r) {
  const auto& [a, b, c] = cell.edges;  // lower triangular: a along x, b in the plane of x and y
  for (std::size_t i = 0; i < r.size(); i += 3) {
    const auto take = [&](const Vector3& edge, std::size_t d) {
      if (!cell.repeats[d]) return;
      const double n = std::floor(r[i + d] / edge[d]);
      for (std::size_t k = 0; k < 3; ++k) r[i + k] -= n * edge[k];
    };
    take(c, 2);
    take(b, 1);
    take(a, 0);
  }
  return r;
}

/// Returns the largest distance between the nearest images of two sets of points.
double largest_distance(const PeriodicCell& cell, const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> difference(a.size());
  for (std::size_t k = 0; k < a.size(); ++k) difference[k] = a[k] - b[k] + 0.25;
  difference = wrap(cell, difference);
  double largest = 0.0;
  for (const double each : difference) largest = std::max(largest, std::abs(each - 0.25));
  return largest;
}

const PeriodicCell orthogonal{Edges{Vector3{3, 0, 0}, {0, 4, 0}, {0, 0, 3.5}}};
const PeriodicCell triclinic{Edges{Vector3{3, 0, 0}, {0.7, 4, 0}, {-0.5, 0.9, 3.5}}};
const PeriodicCell slab{Edges{Vector3{3, 0, 0}, {0.7, 4, 0}, {0, 0, 1}}, {true, true, false}};

/// Two crumpled chains and a triangle that cross the faces many times.
struct Crumpled {
  std::vector<double> masses, r, v;
  std::vector<Constraint> constraints;

  Crumpled() {
    Rods rods{"rods", {}, {}, {}};
    double x = 0.3, y = 0.4, z = 0.2;
    for (Index i = 0; i < 63; ++i) {
      const double s = i;
      r.insert(r.end(), {x, y, z});
      v.insert(v.end(), {std::sin(3.0 * s), std::cos(5.0 * s + 1.0), std::sin(7.0 * s + 2.0)});
      masses.push_back(1.0 + 0.5 * (i % 3));
      if (i % 30 != 0 && i < 60) rods.pairs.push_back(i % 4 == 0 ? std::array{i, i - 1} : std::array{i - 1, i});
      x += 0.5 * std::sin(1.3 * s) + 0.3;
      y += 0.6 * std::cos(0.7 * s) + 0.2;
      z += 0.4 * std::sin(2.1 * s + 1.0) - 0.3;
    }
    for (const auto& pair : {std::array<Index, 2>{60, 61}, {61, 62}, {62, 60}}) rods.pairs.push_back(pair);
    constraints = {rods};
  }
};

class PeriodicCellTest : public testing::TestWithParam<PeriodicCell> {};

TEST_P(PeriodicCellTest, WrappedPointsMoveAsUnwrappedOnesDo) {
  const PeriodicCell& cell = GetParam();
  const Crumpled scene;
  Host free(scene.masses, scene.r, scene.constraints);
  Host wrapped(scene.masses, scene.r, {});
  wrapped.r = wrap(cell, scene.r);
  wrapped.constrainer = Constrainer(scene.masses, scene.constraints, wrapped.r, {.cell = cell}, {.threads = 1});
  ASSERT_GT(
      largest_distance({Edges{Vector3{1e9, 0, 0}, {0, 1e9, 0}, {0, 0, 1e9}}, {false, false, false}}, wrapped.r, free.r),
      2.0);
  free.v = wrapped.v = scene.v;
  for (Host* const host : {&free, &wrapped}) host->start();

  for (int k = 0; k < 200; ++k) {
    ASSERT_TRUE(free.step(2e-3)) << free.outcome.what;
    ASSERT_TRUE(wrapped.step(2e-3)) << wrapped.outcome.what;
    wrapped.r = wrap(cell, wrapped.r);
  }

  EXPECT_LE(largest_distance(cell, wrapped.r, free.r), 1e-10);
  const std::vector<double> f(free.r.size(), 0.3);
  const ConstraintReport a = free.constrainer.solve({.positions = free.r, .velocities = free.v, .forces = f});
  const ConstraintReport b = wrapped.constrainer.solve({.positions = wrapped.r, .velocities = wrapped.v, .forces = f});
  ASSERT_TRUE(a.outcome.ok() && b.outcome.ok());
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(a.virial[k], b.virial[k], 1e-8 * std::abs(a.virial[0]));
}

/// A single step agrees to 1e-13, without the differences that grow from it.
TEST_P(PeriodicCellTest, AStepAgreesToRounding) {
  const PeriodicCell& cell = GetParam();
  const Crumpled scene;
  Constrainer free(scene.masses, scene.constraints, scene.r);
  const std::vector<double> old = wrap(cell, scene.r);
  Constrainer wrapped(scene.masses, scene.constraints, old, {.cell = cell});
  std::vector<double> r = scene.r, w_r, v = scene.v, w_v = scene.v;
  for (std::size_t k = 0; k < r.size(); ++k) r[k] += 1e-3 * v[k];
  w_r = wrap(cell, r);

  ASSERT_TRUE(
      free.constrain_positions({.step = 1e-3, .old_positions = scene.r, .positions = r, .velocities = v}).outcome.ok());
  const ConstraintReport report =
      wrapped.constrain_positions({.step = 1e-3, .old_positions = old, .positions = w_r, .velocities = w_v});

  ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
  EXPECT_LE(largest_distance(cell, r, w_r), 1e-13);
  EXPECT_LE(largest_distance({Edges{Vector3{1e9, 0, 0}, {0, 1e9, 0}, {0, 0, 1e9}}, {false, false, false}}, v, w_v),
            1e-10);
  EXPECT_LE(report.violation, 1e-13);
  EXPECT_LE(wrapped.violation(w_r).violation, 3e-13);
}

/// A barostat makes cell and positions grow by 1 % in a step, then the rods get their lengths back.
TEST_P(PeriodicCellTest, MayChangeInEveryStep) {
  PeriodicCell cell = GetParam();
  const Crumpled scene;
  Constrainer free(scene.masses, scene.constraints, scene.r);
  std::vector<double> x = scene.r, old_x, r = wrap(cell, scene.r), old;
  Constrainer wrapped(scene.masses, scene.constraints, r, {.cell = cell});
  std::vector<double> first = scene.v;
  ASSERT_TRUE(wrapped.constrain_velocities({.positions = r, .velocities = first}).outcome.ok());
  for (int k = 0; k < 10; ++k) {
    const PeriodicCell before = cell;
    const double factor = k % 3 == 0 ? 0.99 : 1.01;
    for (std::size_t d = 0; d < 3; ++d)
      for (double& each : cell.edges[d]) each *= cell.repeats[d] ? factor : 1.0;
    old_x = x;
    old = r;
    for (std::size_t i = 0; i < x.size(); ++i) {
      const double own = cell.repeats[i % 3] ? factor : 1.0;
      x[i] = own * (x[i] + 1e-3 * scene.v[i]);
      r[i] = own * (r[i] + 1e-3 * scene.v[i]);
    }
    wrapped.set_cell(cell);
    ASSERT_TRUE(free.constrain_positions({.step = 1e-3, .old_positions = old_x, .positions = x}).outcome.ok());
    // Positions were wrapped between the steps from the third one on, and the call gets the old cell.
    const ConstraintReport report = wrapped.constrain_positions(
        {.step = 1e-3, .old_positions = old, .positions = r, .old_cell = k < 3 ? nullptr : &before});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    ASSERT_LE(largest_distance(cell, x, r), 1e-11) << k;
    std::vector<double> v = scene.v;
    ASSERT_TRUE(wrapped.constrain_velocities({.positions = r, .velocities = v}).outcome.ok());
    if (k >= 2) r = wrap(cell, r);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Cells, PeriodicCellTest, testing::Values(orthogonal, triclinic, slab), [](const auto& instance) {
      return std::string(instance.index == 0 ? "orthogonal" : instance.index == 1 ? "triclinic" : "slab");
    });

// ---- nets that close round the cell ----

/// A zigzag of four points round a cell of length 4, and the same with an offset.
struct Ring {
  PeriodicCell cell{Edges{Vector3{4, 0, 0}, {0, 5, 0}, {0, 0, 5}}};
  std::vector<double> masses{1.0, 2.0, 1.5, 1.0};
  std::vector<double> r{0.5, 0.1, 0, 1.5, 0.6, 0.2, 2.5, 0.2, 0.4, 3.5, 0.7, 0.1};
  std::vector<double> v{0.1, 0.3, -0.2, 0.4, -0.1, 0.6, 0.2, 0.8, -0.5, 0.3, 0.1, 0.7};
  Rods rods{"ring", {{0, 1}, {1, 2}, {2, 3}, {3, 0}}, {}, {}};

  Rods shifted(double length) const {
    Rods result = rods;
    result.offsets = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {length, 0, 0}};
    return result;
  }
};

TEST(RodsRoundACell, MoveAsRodsWithAnOffsetDo) {
  const Ring ring;
  Host reference(ring.masses, ring.r, {ring.shifted(4.0)}), nearest(ring.masses, ring.r, {}),
      given(ring.masses, ring.r, {});
  nearest.r = wrap(ring.cell, ring.r);
  nearest.constrainer = Constrainer(ring.masses, {ring.rods}, nearest.r, {.cell = ring.cell});
  given.constrainer = Constrainer(ring.masses, {ring.rods}, given.r,
                                  {.cell = ring.cell, .images = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {1, 0, 0}}});
  for (Host* const host : {&reference, &nearest, &given}) {
    host->v = ring.v;
    host->start();
    for (int k = 0; k < 500; ++k) {
      ASSERT_TRUE(host->step(5e-3)) << host->outcome.what;
      if (host == &nearest) host->r = wrap(ring.cell, host->r);
    }
  }
  EXPECT_LE(largest_distance(ring.cell, nearest.r, reference.r), 1e-10);
  EXPECT_LE(largest_distance(ring.cell, given.r, reference.r), 1e-10);
}

TEST(RodsRoundACell, KeepTheirLengthsWhenTheCellChanges) {
  Ring ring;
  Constrainer constrainer(ring.masses, {ring.rods}, ring.r, {.cell = ring.cell});
  Rods longer = ring.shifted(4.2);
  std::vector<double> lengths;
  for (std::size_t k = 0; k < 4; ++k) {
    double square = 0.0;
    for (std::size_t d = 0; d < 3; ++d) {
      const double offset = k == 3 && d == 0 ? 4.0 : 0.0;
      const auto [i, j] = ring.rods.pairs[k];
      square += std::pow(
          ring.r[3 * static_cast<std::size_t>(j) + d] + offset - ring.r[3 * static_cast<std::size_t>(i) + d], 2);
    }
    lengths.push_back(std::sqrt(square));
  }
  longer.length = lengths;
  Constrainer reference(ring.masses, {longer}, ring.r);
  ring.cell.edges[0][0] = 4.2;

  constrainer.set_cell(ring.cell);

  EXPECT_NEAR(constrainer.violation(ring.r).violation, reference.violation(ring.r).violation, 1e-15);
  std::vector<double> r = ring.r, same = ring.r;
  ASSERT_TRUE(constrainer.project_positions(r).outcome.ok());
  ASSERT_TRUE(reference.project_positions(same).outcome.ok());
  for (std::size_t k = 0; k < r.size(); ++k) EXPECT_NEAR(r[k], same[k], 1e-12);
}

// ---- errors ----

TEST(PeriodicCellErrors, NameWrongCellsLengthsAndImages) {
  const Ring ring;
  const auto error_with = [&](const Constraint& constraint, const Periodicity& periodicity) {
    return error_of([&] { (void)Constrainer(ring.masses, {constraint}, ring.r, periodicity); });
  };
  Rods long_one = ring.rods;
  long_one.length = std::vector{1.1, 1.1, 2.3, 1.1};
  EXPECT_EQ(
      error_with(long_one, {.cell = ring.cell}),
      "/cell: ring[2] has the length 2.3, no less than half of the cell, whose faces are 4 apart; tell which images "
      "the rods join");
  EXPECT_NE(error_with(ring.rods, {.cell = {Edges{Vector3{1, 0, 0}, {2, 0, 0}, {0, 0, 1}}}}).find("span space"),
            std::string::npos);
  const double least = std::numeric_limits<double>::denorm_min();  // 1/least is no number
  for (const Edges& edges :
       {Edges{Vector3{least, 0, 0}, {0, 10, 0}, {0, 0, 10}}, Edges{Vector3{10, 0, 0}, {0, least, 0}, {0.1, 2, 10}}})
    EXPECT_NE(error_with(ring.rods, {.cell = {edges}}).find("span space"), std::string::npos);
  EXPECT_EQ(error_with(ring.shifted(4.0), {.cell = ring.cell}),
            "/cell: ring has offsets; in a cell rods have images instead");
  EXPECT_EQ(error_with(ring.rods, {.cell = ring.cell, .images = {{0, 0, 0}}}),
            "/cell: images has 1 entries; 4 are needed, one a row");
  Constrainer without(ring.masses, {ring.rods}, ring.r), with(ring.masses, {ring.rods}, ring.r, {.cell = ring.cell});
  EXPECT_NE(error_of([&] { without.set_cell(ring.cell); }).find("there is none"), std::string::npos);
  PeriodicCell small = ring.cell;
  small.edges[0][0] = 2.0;
  EXPECT_NE(error_of([&] { with.set_cell(small); }).find("ring["), std::string::npos);
  std::vector<double> v = ring.v;  // and the handle goes on in its old cell
  EXPECT_TRUE(with.constrain_velocities({.positions = ring.r, .velocities = v}).outcome.ok());
}

}  // namespace
}  // namespace tanor::host
