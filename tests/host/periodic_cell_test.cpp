/// The tests compare rods in a periodic cell with the same rods where nothing is wrapped.

#include <gtest/gtest.h>

#include <Eigen/Dense>

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
  const ConstraintReport report = constrainer.project_positions(r), expected = reference.project_positions(same);
  ASSERT_TRUE(report.outcome.ok() && expected.outcome.ok());
  EXPECT_NEAR(report.largest_turn, expected.largest_turn, 1e-12);
  EXPECT_GT(report.largest_turn, 1e-3);
  for (std::size_t k = 0; k < r.size(); ++k) EXPECT_NEAR(r[k], same[k], 1e-12);
}

// ---- nets that close round a cell that changes within a step ----

/// Rods that close ways round a triclinic cell, with the numbers of edges that their ends are apart.
struct Closing {
  std::string name;
  std::vector<LinearSolver> solvers;  // those that serve it
  std::vector<double> masses, r;
  std::vector<std::array<Index, 2>> pairs{};
  std::vector<std::array<int, 3>> apart{};

  void join(Index i, Index j, std::array<int, 3> n = {0, 0, 0}) {
    pairs.push_back({i, j});
    apart.push_back(n);
  }
  Rods rods() const { return {"rods", pairs, {}, {}}; }
  /// Returns r_j + H n - r_i of a rod.
  Eigen::Vector3d vector(std::size_t rod, const PeriodicCell& cell, const std::vector<double>& at) const {
    const auto [i, j] = pairs[rod];
    Eigen::Vector3d result = Eigen::Map<const Eigen::Vector3d>(&at[3 * static_cast<std::size_t>(j)]) -
                             Eigen::Map<const Eigen::Vector3d>(&at[3 * static_cast<std::size_t>(i)]);
    for (std::size_t k = 0; k < 3; ++k)
      result += apart[rod][k] * Eigen::Map<const Eigen::Vector3d>(cell.edges[k].data());
    return result;
  }
  /// Returns K [3n, rods].
  Eigen::MatrixXd gradients(const PeriodicCell& cell, const std::vector<double>& at) const {
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(at.size()), std::ssize(pairs));
    for (std::size_t rod = 0; rod < pairs.size(); ++rod) {
      const Eigen::Vector3d unit = vector(rod, cell, at).normalized();
      k.block<3, 1>(3 * pairs[rod][0], static_cast<Eigen::Index>(rod)) = -unit;
      k.block<3, 1>(3 * pairs[rod][1], static_cast<Eigen::Index>(rod)) = unit;
    }
    return k;
  }
  Eigen::VectorXd inverse_masses() const {
    Eigen::VectorXd result(std::ssize(r));
    for (Eigen::Index k = 0; k < result.size(); ++k) result[k] = 1.0 / masses[static_cast<std::size_t>(k / 3)];
    return result;
  }
  /// Moves `free` along M^-1 K at `from` in the cell `before` until all rods have their lengths in the cell `now`, by
  /// Newton's method on dense matrices.
  std::vector<double> project(const std::vector<double>& from, const PeriodicCell& before, std::vector<double> free,
                              const PeriodicCell& now, const PeriodicCell& first) const {
    const Eigen::MatrixXd along = inverse_masses().asDiagonal() * gradients(before, from);
    for (int pass = 0; pass < 20; ++pass) {
      Eigen::VectorXd xi(std::ssize(pairs));
      for (std::size_t k = 0; k < pairs.size(); ++k)
        xi[static_cast<Eigen::Index>(k)] = vector(k, now, free).norm() - vector(k, first, r).norm();
      Eigen::Map<Eigen::VectorXd>(free.data(), std::ssize(free)) -=
          along * (gradients(now, free).transpose() * along).partialPivLu().solve(xi);
    }
    return free;
  }
};

Closing make_ring() {
  const Ring ring;
  Closing result{"ring",
                 {LinearSolver::Auto, LinearSolver::General, LinearSolver::Paths, LinearSolver::Batches},
                 ring.masses,
                 ring.r};
  for (const auto& [i, j] : {std::array<Index, 2>{0, 1}, {2, 1}, {2, 3}}) result.join(i, j);
  result.join(3, 0, {1, 0, 0});
  return result;
}

/// Three by three points that close along two edges.
Closing make_net(const PeriodicCell& cell) {
  Closing result{"net", {LinearSolver::Auto, LinearSolver::General, LinearSolver::Batches}, {}, {}};
  const auto point = [](int i, int j) { return static_cast<Index>(3 * (i % 3) + j % 3); };
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double s = 3 * i + j;
      for (std::size_t k = 0; k < 3; ++k)
        result.r.push_back(i * cell.edges[0][k] / 3 + j * cell.edges[1][k] / 3 +
                           0.25 * std::sin(2.0 * s + 1.3 * static_cast<double>(k)));
      result.masses.push_back(1.0 + 0.1 * s);
      result.join(point(i, j), point(i + 1, j), {i == 2 ? 1 : 0, 0, 0});
      result.join(point(i, j + 1), point(i, j), {0, j == 2 ? -1 : 0, 0});
    }
  }
  return result;
}

/// Two chains between two supports, one of them round the cell.
Closing make_chains_of_supports(const PeriodicCell& cell) {
  Closing result{
      "chains",
      {LinearSolver::Auto, LinearSolver::General, LinearSolver::Paths, LinearSolver::Batches, LinearSolver::Trees},
      {infinity, 1.0, 2.0, infinity, 1.5, 1.0},
      {}};
  for (int i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 3; ++k)
      result.r.push_back(i * cell.edges[0][k] / 6 + 0.1 * std::sin(2.0 * i + static_cast<double>(k)));
  for (Index i = 0; i < 5; ++i) result.join(i, i + 1);
  result.join(5, 0, {1, 0, 0});
  return result;
}

class ClosingRods : public testing::TestWithParam<int> {};

/// The cell shrinks by 0.02 % and shears in each step. Rods pull along the old cell's directions, and have their
/// lengths in the new one.
TEST_P(ClosingRods, PullAlongTheOldCellAndFitTheNewOne) {
  const PeriodicCell first{Edges{Vector3{4, 0, 0}, {0.7, 4.2, 0}, {-0.4, 0.3, 5}}};
  const Closing scene = GetParam() == 0   ? make_ring()
                        : GetParam() == 1 ? make_net(first)
                                          : make_chains_of_supports(first);
  for (std::size_t number = 0; number < 2 * scene.solvers.size(); ++number) {
    const LinearSolver solver = scene.solvers[number / 2];
    const bool are_given = number % 2 == 1;
    SCOPED_TRACE(scene.name + " by solver " + std::to_string(static_cast<int>(solver)) +
                 (are_given ? ", images given" : ""));
    PeriodicCell cell = first;
    Periodicity periodicity{.cell = cell};
    if (are_given) periodicity.images = scene.apart;
    Constrainer constrainer(scene.masses, {scene.rods()}, scene.r, periodicity, {.linear_solver = solver});
    std::vector<double> r = scene.r, v(r.size(), 0.0);
    constexpr double h = 1e-2;
    for (int k = 0; k < 4; ++k) {
      const std::vector<double> old = r;
      const PeriodicCell before = cell;
      for (Vector3& edge : cell.edges) {
        for (double& x : edge) x *= 0.9998;
        edge[1] += 2e-4 * edge[0];
      }
      for (std::size_t i = 0; i < r.size(); i += 3) {
        for (std::size_t d = 0; d < 3; ++d) r[i + d] *= 0.9998;
        r[i + 1] += 2e-4 * r[i];
        if (scene.masses[i / 3] < infinity) r[i + 2] += 0.01 * std::sin(static_cast<double>(i) + k);
      }
      const std::vector<double> expected = scene.project(old, before, r, cell, first);

      constrainer.set_cell(cell);
      EXPECT_EQ(constrainer.update_plan(), 0U);
      const ConstraintReport report = constrainer.constrain_positions(
          {.step = h, .old_positions = old, .positions = r, .old_cell = k % 2 == 0 ? &before : nullptr});

      ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
      double turn = 0.0;
      for (std::size_t rod = 0; rod < scene.pairs.size(); ++rod) {
        const Eigen::Vector3d a = scene.vector(rod, before, old), b = scene.vector(rod, cell, r);
        turn = std::max(turn, std::atan2(a.cross(b).norm(), a.dot(b)));
      }
      EXPECT_NEAR(report.largest_turn, turn, 1e-9);
      // The iterations end at 1e-13 of a length, which the net's shape makes ten times as much of a place.
      for (std::size_t i = 0; i < r.size(); ++i) ASSERT_NEAR(r[i], expected[i], 1e-11) << k;
      for (std::size_t i = 0; i < v.size(); ++i)
        v[i] = scene.masses[i / 3] < infinity ? std::cos(3.0 * static_cast<double>(i)) : 0.0;
      ASSERT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome.ok());
      const Eigen::VectorXd rates =
          scene.gradients(cell, r).transpose() * Eigen::Map<const Eigen::VectorXd>(v.data(), std::ssize(v));
      EXPECT_LE(rates.cwiseAbs().maxCoeff(), 1e-13);
      EXPECT_LE(constrainer.violation(r).violation, 1e-13);
    }
    // An edit plans islands anew, with the offsets of the present cell.
    constrainer.remove(std::array<ConstraintId, 1>{1});
    std::vector<double> other_v(r.size(), 1.0);
    for (std::size_t i = 0; i < r.size(); ++i)
      other_v[i] = scene.masses[i / 3] < infinity ? std::sin(5.0 * static_cast<double>(i)) : 0.0;
    ASSERT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = other_v}).outcome.ok());
    Eigen::VectorXd rates =
        scene.gradients(cell, r).transpose() * Eigen::Map<const Eigen::VectorXd>(other_v.data(), std::ssize(other_v));
    EXPECT_GT(std::abs(std::exchange(rates[1], 0.0)), 1e-3);
    EXPECT_LE(rates.cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LE(constrainer.violation(r).violation, 1e-13);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, ClosingRods, testing::Values(0, 1, 2), [](const auto& instance) {
  return std::string(instance.param == 0 ? "ring" : instance.param == 1 ? "net" : "chains");
});

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

/// A point that nothing holds may be anywhere: its other coordinates stay as they are.
TEST(PeriodicCells, ACoordinateThatIsNoNumberSpoilsNoOther) {
  const std::vector<double> masses(3, 1.0), old{0.2, 1, 1, 1.2, 1, 1, 2, 2, 2};
  Constrainer constrainer(masses, {Rods{"rods", {{0, 1}}, {}, {}}}, old,
                          {.cell = {.edges = {{{4, 0, 0}, {0.5, 4, 0}, {0.1, 0.2, 4}}}}});
  for (const double wrong : {nan, infinity}) {
    std::vector<double> r = old, v(9, 0.0);
    r[7] = wrong;

    const ConstraintReport report =
        constrainer.constrain_positions({.step = 0.01, .old_positions = old, .positions = r, .velocities = v});

    EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_EQ(r[6], 2.0);
    EXPECT_EQ(r[8], 2.0);
    r[3] = wrong;
    EXPECT_EQ(constrainer.constrain_positions({.step = 0.01, .old_positions = old, .positions = r}).outcome.status,
              Status::NotFinite);
  }
}

}  // namespace
}  // namespace tanor::host
