/// Mechanisms on pins move at no cost, and frameworks that no stress stiffens do so too: neither is stable.

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Dense>
#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>

#include "dense.hpp"
#include "reference.hpp"

namespace tanor {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;
using Pairs = std::vector<std::array<Index, 2>>;

System make_framework(const std::vector<Vector3>& places, const Pairs& bars, const std::vector<Index>& pins = {}) {
  System system;
  for (const Vector3& place : places) system.positions.insert(system.positions.end(), place.begin(), place.end());
  system.masses.assign(places.size(), 1.0);
  if (!pins.empty()) system.supports = {{"pins", pins, {}}};
  system.constraints = {Rods{.name = "bars", .pairs = bars}};
  return system;
}

void expect_marginal(const System& system, std::size_t zero_modes, std::size_t rigid) {
  const EquilibriumResult found = find_equilibrium(system);

  EXPECT_EQ(found.outcome.status, Status::NoSolution);
  EXPECT_NE(found.outcome.what.find("marginal"), std::string::npos) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Marginal);
  EXPECT_EQ(found.stability.zero_modes, zero_modes);
  EXPECT_EQ(found.stability.rigid_zero_modes, rigid);
}

TEST(MechanismsOnPins, AreMarginal) {
  System frame = make_framework({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 3}, {3, 2}, {2, 1}}, {0, 1});
  frame.constraints.push_back(Planes{"flat", {2, 3}, Vector3{0, 0, 1}});
  expect_marginal(frame, 1, 0);

  System crank = make_framework({{0, 0, 0}, {0.3, 0.4, 0}, {1.1, 0, 0}}, {{0, 1}, {1, 2}}, {0});
  crank.constraints.push_back(Lines{"slide", {2}, Vector3{}, Vector3{1, 0, 0}});
  crank.constraints.push_back(Planes{"flat", {1}, Vector3{0, 0, 1}});
  expect_marginal(crank, 1, 0);

  expect_marginal(make_framework({{0, 0, 0}, {0, 0, -1}, {1, 0, -1}}, {{0, 1}, {1, 2}}, {0}), 4, 0);
  expect_marginal(make_framework({{0, 0, 0}, {0, 0, -1}}, {{0, 1}}, {0}), 2, 0);

  // A link turns about a point that bars to three pins hold.
  expect_marginal(make_framework({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.2, 1}, {0.4, 0.1, 2}},
                                 {{0, 3}, {1, 3}, {2, 3}, {3, 4}}, {0, 1, 2}),
                  2, 0);

  // A panel on a shaft carries a link: each alone could turn as a whole.
  expect_marginal(make_framework({{0, 0, 0}, {0, 1, 0}, {1, 0.5, 0}, {1.5, 0.5, 1}}, {{0, 2}, {1, 2}, {2, 3}}, {0, 1}),
                  3, 0);
}

/// A body that moves freely, in a plane or about the axis of a wire moves as a whole. Where pins hold it and nothing
/// loads it, what they leave is a mechanism, whether it has one point or more.
TEST(MotionsOfTheWhole, CostNothingAndAreStable) {
  const std::vector<Vector3> corners{{0, 0, 0}, {1, 0, 0.2}, {0.3, 0.9, 0}, {0.2, 0.3, 1}};
  const Pairs edges{{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
  const auto in_plane = [](System system, const std::vector<Index>& points) {
    for (std::size_t i = 2; i < system.positions.size(); i += 3) system.positions[i] = 0.0;
    system.constraints.push_back(Planes{"flat", points, Vector3{0, 0, 1}});
    return system;
  };
  const System triangle = make_framework({{0, 0, 0}, {1, 0, 0}, {0.3, 0.9, 0}}, {{0, 1}, {1, 2}, {0, 2}}, {0});
  System ring = make_framework({{1, 0, 0}, {0, 1, 0}, {-0.6, 0.8, 0}}, {{0, 1}});
  ring.constraints.push_back(Circles{"wire", {0, 1}, Vector3{}, Vector3{0, 0, 1}, 1.0});
  ring.constraints.erase(ring.constraints.begin());
  ring.constraints.push_back(Planes{"flat", {2}, Vector3{0, 0, 1}});
  ring.forces = {Springs{.name = "spring", .pairs = {{0, 1}, {1, 2}, {0, 2}}, .stiffness = 10.0}};
  System two = make_framework(corners, edges);
  two.positions.insert(two.positions.end(), {5, 5, 5, 6, 5, 5});
  two.masses.resize(6, 1.0);
  std::get<Rods>(two.constraints[0]).pairs.push_back({4, 5});
  System in_a_plane = in_plane(triangle, {0, 1, 2});
  in_a_plane.supports.clear();
  for (const auto& [system, rigid] : {std::pair{make_framework(corners, edges, {0, 1, 2}), 0u},
                                      {in_a_plane, 3u},
                                      {make_framework(corners, edges), 6u},
                                      {two, 11u},
                                      {ring, 1u}}) {
    const EquilibriumResult found = find_equilibrium(system);

    ASSERT_TRUE(found.outcome.ok()) << rigid << ": " << found.outcome.what;
    EXPECT_EQ(found.stability.zero_modes, rigid);
    EXPECT_EQ(found.stability.rigid_zero_modes, rigid);
  }
  for (const auto& [system, zero_modes] : {std::pair{make_framework(corners, edges, {0}), 3u},
                                           {make_framework(corners, edges, {0, 1}), 1u},
                                           {in_plane(triangle, {1, 2}), 1u}})
    expect_marginal(system, zero_modes, 0);
}

/// Under its weight the same body hangs; what it can do besides, turn about the vertical, leaves the load as it is.
TEST(BodyAtAPin, HangsUnderItsWeight) {
  System body = make_framework({{0, 0, 0}, {1, 0, 0.2}, {0.3, 0.9, 0}, {0.2, 0.3, 1}},
                               {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}}, {0});
  body.add_gravity({0.0, 0.0, -9.81});

  const EquilibriumResult found = find_equilibrium(body);

  ASSERT_TRUE(found.outcome.ok()) << found.outcome.what;
  EXPECT_EQ(found.stability.status, Stability::Stable);
  EXPECT_EQ(found.stability.zero_modes, 1u);
  EXPECT_EQ(found.stability.rigid_zero_modes, 1u);
}

/// Makes the edges of a box and bars from an apex at the height h (beyond 1: outside) to all its corners; `map` deforms
/// everything.
System make_coned_box(double height, const Eigen::Matrix3d& map) {
  std::vector<Eigen::Vector3d> corners;
  for (int k = 0; k < 8; ++k) corners.emplace_back((k >> 2) & 1, (k >> 1) & 1, k & 1);
  corners.push_back({0.5, 0.5, height});
  Pairs bars;
  for (Index i = 0; i < 8; ++i) {
    for (Index j = i + 1; j < 8; ++j) {
      if ((corners[static_cast<std::size_t>(i)] - corners[static_cast<std::size_t>(j)]).norm() < 1.1)
        bars.push_back({i, j});
    }
  }
  for (Index i = 0; i < 8; ++i) bars.push_back({8, i});
  std::vector<Vector3> places;
  for (const Eigen::Vector3d& corner : corners) {
    const Eigen::Vector3d place = map * corner;
    places.push_back({place[0], place[1], place[2]});
  }
  return make_framework(places, bars);
}

TEST(SelfStressOfFrameworks, StiffensAConedCubeFromInsideAlone) {
  expect_marginal(make_coned_box(7.0 / 6.0, Eigen::Matrix3d::Identity()), 8, 6);

  const EquilibriumResult inside = find_equilibrium(make_coned_box(0.9, Eigen::Matrix3d::Identity()));

  ASSERT_TRUE(inside.outcome.ok()) << inside.outcome.what;
  EXPECT_EQ(inside.stability.status, Stability::Stable);
  EXPECT_EQ(inside.stability.rigid_zero_modes, 6u);
}

TEST(SelfStressOfFrameworks, OfBarsThatLieOnEachOtherStiffensNothing) {
  expect_marginal(
      make_framework({{0, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {1, 0, 0}}, {{0, 1},
                                                                                                     {0, 2},
                                                                                                     {0, 3},
                                                                                                     {0, 5},
                                                                                                     {0, 6},
                                                                                                     {1, 2},
                                                                                                     {1, 4},
                                                                                                     {1, 6},
                                                                                                     {2, 3},
                                                                                                     {2, 4},
                                                                                                     {3, 4},
                                                                                                     {3, 5},
                                                                                                     {4, 5},
                                                                                                     {4, 6},
                                                                                                     {5, 6}}),
      8, 6);
}

// ---- random frameworks, dense ------------------------------------------------------------------------------------

/// K of the rods with the moving points' rows, its null vectors, and its states of self-stress.
struct DenseFramework {
  explicit DenseFramework(const System& system) {
    const std::vector<double> at_rest(system.positions.size(), 0.0);
    const reference::Mechanics mechanics = reference::make_mechanics(system, 0.0, system.positions, at_rest);
    coordinates = mechanics.coordinates;
    K = mechanics.K;
    constexpr double dependent = 1e-9;
    MatrixXd V;
    const VectorXd of_motions = reference::singular_values(K.transpose(), &V);
    rank = (of_motions.array() > dependent).count();
    motions = V.rightCols(K.rows() - rank);
    (void)reference::singular_values(K, &V);
    stresses = V.rightCols(K.cols() - rank);
    clear_gap = rank == 0 || of_motions[rank - 1] > 1e-3;
  }

  std::vector<Eigen::Index> coordinates;
  MatrixXd K, motions, stresses;
  Eigen::Index rank = 0;
  bool clear_gap = false;
};

/// Returns x'Omega x for x of `motions`, where a bar with the stress omega has the energy omega |dx|^2/(2 length).
MatrixXd stiffness_of_stress(const System& system, const VectorXd& stress, const MatrixXd& motions) {
  const Pairs& bars = std::get<Rods>(system.constraints[0]).pairs;
  MatrixXd result = MatrixXd::Zero(motions.cols(), motions.cols());
  for (std::size_t k = 0; k < bars.size(); ++k) {
    const auto [i, j] = bars[k];
    const double length = (reference::point(system.positions, j) - reference::point(system.positions, i)).norm();
    const MatrixXd change = motions.middleRows(3 * j, 3) - motions.middleRows(3 * i, 3);
    result += stress[static_cast<Eigen::Index>(k)] / length * change.transpose() * change;
  }
  return result;
}

/// Boxes of any shape with an apex anywhere on their axis have one stress and two flexes: definite inside alone.
TEST(RandomFrameworks, AreStableWhereTheirStressIsDefinite) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> any(-0.4, 0.4), height(0.15, 2.5);
  int stable = 0, marginal = 0;
  for (int each = 0; each < 100; ++each) {
    Eigen::Matrix3d map = Eigen::Matrix3d::Identity();
    for (double& x : map.reshaped()) x += any(random);
    const System system = make_coned_box(height(random), map);
    const DenseFramework dense(system);
    if (dense.stresses.cols() != 1 || !dense.clear_gap) continue;
    const VectorXd values = reference::eigenvalues(stiffness_of_stress(system, dense.stresses.col(0), dense.motions));
    const double scale = values.cwiseAbs().maxCoeff();
    const auto positive = (values.array() > 1e-7 * scale).count(), negative = (values.array() < -1e-7 * scale).count();
    const bool is_definite = std::max(positive, negative) == dense.motions.cols() - 6;

    const EquilibriumResult found = find_equilibrium(system);

    EXPECT_EQ(found.stability.status, is_definite ? Stability::Stable : Stability::Marginal) << each;
    EXPECT_EQ(found.stability.zero_modes, is_definite ? 6u : static_cast<std::size_t>(dense.motions.cols())) << each;
    EXPECT_EQ(found.stability.rigid_zero_modes, 6u) << each;
    (is_definite ? stable : marginal) += 1;
  }
  EXPECT_GT(stable, 10);
  EXPECT_GT(marginal, 10);
}

/// Numbers the groups of moving points that bars join, [point]; -1 for pins.
std::vector<int> find_groups(const System& system) {
  std::vector<int> group(system.num_points());
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = static_cast<int>(i);
  for (const Support& support : system.supports) {
    for (const Index pin : support.points) group[static_cast<std::size_t>(pin)] = -1;
  }
  for (std::size_t round = 0; round < group.size(); ++round) {
    for (const auto& [i, j] : std::get<Rods>(system.constraints[0]).pairs) {
      int &a = group[static_cast<std::size_t>(i)], &b = group[static_cast<std::size_t>(j)];
      if (a >= 0 && b >= 0) a = b = std::min(a, b);
    }
  }
  return group;
}

/// Lists the pairs of points whose distances say whether a group moves as a whole: all of its points, and its pins.
Pairs list_distances(const System& system) {
  const std::vector<int> group = find_groups(system);
  Pairs result;
  const auto own = [&](Index i) { return group[static_cast<std::size_t>(i)]; };
  const auto count = static_cast<Index>(group.size());
  for (Index i = 0; i < count; ++i) {
    for (Index j = 0; j < count; ++j) {
      if (own(i) < 0) continue;
      const bool is_pinned = std::ranges::any_of(std::get<Rods>(system.constraints[0]).pairs, [&](const auto& bar) {
        return (bar[0] == j && own(bar[1]) == own(i)) || (bar[1] == j && own(bar[0]) == own(i));
      });
      if (own(j) < 0 ? is_pinned : own(j) == own(i) && j < i) result.push_back({i, j});
    }
  }
  return result;
}

/// Moves along the null vectors as far as a tenth, back onto all lengths by dense steps, and returns the largest change
/// of a distance within a group, or of a place if the point is alone.
double flex(const System& system, const DenseFramework& dense, const VectorXd& direction) {
  System moved = system;
  const auto distances = [](const std::vector<double>& r, const Pairs& pairs) {
    VectorXd result(static_cast<Eigen::Index>(pairs.size()));
    for (std::size_t k = 0; k < pairs.size(); ++k)
      result[static_cast<Eigen::Index>(k)] =
          (reference::point(r, pairs[k][1]) - reference::point(r, pairs[k][0])).norm();
    return result;
  };
  const auto move = [&](const VectorXd& by) {
    for (std::size_t k = 0; k < dense.coordinates.size(); ++k)
      moved.positions[static_cast<std::size_t>(dense.coordinates[k])] += by[static_cast<Eigen::Index>(k)];
  };
  const Pairs& bars = std::get<Rods>(system.constraints[0]).pairs;
  const VectorXd wanted = distances(system.positions, bars);
  move(0.1 * direction);
  for (int step = 0; step < 10; ++step) {
    const MatrixXd K = DenseFramework(moved).K;
    VectorXd rest = VectorXd::Zero(K.cols());  // planes are kept by each step
    rest.head(wanted.size()) = wanted - distances(moved.positions, bars);
    move(reference::solve_least_squares(K.transpose(), rest, 1e-9));
  }
  const Pairs pairs = list_distances(system);
  double worst = (distances(moved.positions, pairs) - distances(system.positions, pairs)).cwiseAbs().maxCoeff();
  const std::vector<int> group = find_groups(system);
  for (std::size_t i = 0; i < group.size(); ++i) {
    if (group[i] < 0 || std::ranges::count(group, group[i]) > 1) continue;
    const auto point = static_cast<Index>(i);
    worst =
        std::max(worst, (reference::point(moved.positions, point) - reference::point(system.positions, point)).norm());
  }
  return worst;
}

/// Trees, loops and bodies that are free or on one or two pins, in space and in a plane. What flexes changes a distance
/// between points; what is free and does not moves as a whole. What moves on pins is a mechanism.
TEST(RandomFrameworks, OnPinsAreStableWhereNothingFlexes) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0), part(0.0, 1.0);
  int rigid = 0, flexible = 0, judged = 0;
  for (int each = 0; judged < 300; ++each) {
    const int moving = 2 + each % 4, pins = each % 3;
    const bool is_flat = each % 5 < 2;
    std::vector<Vector3> places;
    for (int i = 0; i < moving + pins; ++i) places.push_back({any(random), any(random), is_flat ? 0.0 : any(random)});
    Pairs bars;
    std::vector<Index> held, free;
    for (Index i = 0; i < moving + pins; ++i) {
      (i < pins ? held : free).push_back(i);
      if (i < pins) continue;
      std::vector<Index> others;
      for (Index j = 0; j < i; ++j) others.push_back(j);
      std::ranges::shuffle(others, random);
      const std::size_t count =
          std::min<std::size_t>(others.size(), part(random) < 0.4 ? (is_flat ? 2 : 3) : 1 + each / 3 % 3);
      for (std::size_t k = 0; k < count; ++k) bars.push_back({others[k], i});
    }
    System system = make_framework(places, bars, held);
    if (is_flat) system.constraints.push_back(Planes{"flat", free, Vector3{0, 0, 1}});
    const DenseFramework dense(system);
    if (dense.stresses.cols() > 0 || !dense.clear_gap) continue;
    double change = 0.0;
    for (int trial = 0; trial < 3 && dense.motions.cols() > 0; ++trial) {
      VectorXd x(dense.motions.cols());
      for (double& value : x) value = any(random);
      change = std::max(change, flex(system, dense, dense.motions * x.normalized()));
    }
    if (change > 1e-9 && change < 1e-4) continue;
    const bool is_rigid = pins == 0 ? change <= 1e-9 : dense.motions.cols() == 0;
    ++judged;

    const EquilibriumResult found = find_equilibrium(system);

    EXPECT_EQ(found.stability.zero_modes, static_cast<std::size_t>(dense.motions.cols())) << each;
    EXPECT_EQ(found.stability.status, is_rigid ? Stability::Stable : Stability::Marginal) << each;
    EXPECT_EQ(found.outcome.ok(), is_rigid) << each;
    EXPECT_EQ(found.stability.rigid_zero_modes == found.stability.zero_modes, is_rigid) << each;
    if (pins == 0) {
      const std::size_t whole = is_flat ? 3u : moving > 2 ? 6u : 5u;
      EXPECT_EQ(found.stability.rigid_zero_modes, whole) << each;
    }
    (is_rigid ? rigid : flexible) += 1;
  }
  EXPECT_GT(rigid, 60);
  EXPECT_GT(flexible, 100);
}

}  // namespace
}  // namespace tanor
