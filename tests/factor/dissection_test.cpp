/// Nested dissection of points gives orders of rows, whose cost and choice are tested.

#include "factor/dissection.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "factor/supernodes.hpp"
#include "patterns.hpp"
#include "plan/thresholds.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

SymbolicAnalysis analysis_of(const Rods& rods, Ordering wanted, double noise = 0.1) {
  return analyze(pattern_of(rods), wanted, [&] { return points_of(rods, noise); });
}

/// Makes a net that was folded and pressed into a ball, so that coordinates do not tell which points are joined.
Rods make_crumpled_net(int side) {
  Rods rods = make_net(side, side);
  for (std::size_t k = 0; k < rods.positions.size(); k += 3) {
    const double x = rods.positions[k], y = rods.positions[k + 1];
    rods.positions[k] = std::sin(0.33 * x + 0.17 * y);
    rods.positions[k + 1] = std::cos(0.31 * y - 0.15 * x);
    rods.positions[k + 2] = std::sin(0.29 * (x + y) + std::sin(0.7 * x));
  }
  return rods;
}

RC_GTEST_PROP(Dissection, OrdersHaveEveryRowOnce, ()) {
  const auto num_points = *rc::gen::inRange(1, 60).as("points");
  const auto point = rc::gen::inRange(0, num_points);
  RowsInSpace rows;
  for (int k = 0; k < 3 * num_points; ++k)  // some of them coincide
    rows.positions.push_back(*rc::gen::inRange(0, 5));
  const auto groups = *rc::gen::container<std::vector<std::set<int>>>(
      rc::gen::nonEmpty(rc::gen::container<std::set<int>>(*rc::gen::inRange(1, 1 + std::min(num_points, 4)), point)));
  for (const std::set<int>& group : groups) {
    rows.points_of_row.entries.insert(rows.points_of_row.entries.end(), group.begin(), group.end());
    rows.points_of_row.end_group();
  }
  for (std::vector<int> order : {dissect_along_axes(rows).order, dissect_graph(rows).order}) {
    std::ranges::sort(order);
    std::vector<int> all(groups.size());
    for (std::size_t k = 0; k < all.size(); ++k) all[k] = static_cast<int>(k);
    RC_ASSERT(order == all);
  }
}

TEST(Dissection, FirstCutOfANetIsItsMiddleAndItsRodsFollowTheCut) {
  const Rods rods = make_net(24, 16);
  const RowsInSpace points = points_of(rods, 0.2);

  const Dissection along_axes = dissect_along_axes(points);

  EXPECT_DOUBLE_EQ(along_axes.first_cut, 16.0 / (192.0 * 192.0));
  EXPECT_LE(along_axes.first_cut, first_cut_of_graph(points));
  std::set<int> met;
  for (std::size_t k = 0; k < 16; ++k) {
    const auto [a, b] = rods.ends[static_cast<std::size_t>(along_axes.order[rods.ends.size() - 16 + k])];
    EXPECT_EQ(a / 16, 11);
    EXPECT_EQ(b / 16, 12);
    met.insert(a % 16);
  }
  EXPECT_EQ(met.size(), 16u);
}

/// Returns the average number of rows of fronts that follow one another in the parent's rows.
double length_of_runs(const TrianglePattern& lower) {
  const Supernodes all = find_supernodes(lower);
  std::vector<std::size_t> supernode_of(lower.size());
  for (std::size_t s = 0; s < all.size(); ++s)
    for (int j = all.first_column[s]; j < all.first_column[s + 1]; ++j) supernode_of[static_cast<std::size_t>(j)] = s;
  double rows = 0.0, runs = 0.0;
  for (std::size_t s = 0; s < all.size(); ++s) {
    const auto columns = static_cast<std::size_t>(all.first_column[s + 1] - all.first_column[s]);
    const std::size_t first = all.rows_start[s] + columns, end = all.rows_start[s + 1];
    if (end - first < 32) continue;  // small fronts have no long runs
    const std::size_t parent = supernode_of[static_cast<std::size_t>(all.rows[first])];
    const auto in_parent = all.rows.begin() + static_cast<std::ptrdiff_t>(all.rows_start[parent]);
    const auto end_of_parent = all.rows.begin() + static_cast<std::ptrdiff_t>(all.rows_start[parent + 1]);
    const auto place = [&](std::size_t k) { return std::lower_bound(in_parent, end_of_parent, all.rows[k]); };
    for (std::size_t k = first; k < end; ++k) runs += k == first || place(k) != place(k - 1) + 1 ? 1.0 : 0.0;
    rows += static_cast<double>(end - first);
  }
  return rows / runs;
}

TEST(Dissection, FrontsMeetSeparatorsInLongRuns) {
  for (const Rods& rods : {make_net(70, 64), make_lattice(12)}) {
    const auto runs = [&](Ordering wanted) {
      return length_of_runs(pattern_of(rods, analysis_of(rods, wanted).permutation));
    };
    EXPECT_GE(runs(Ordering::Axes), 10.0);
    EXPECT_GE(runs(Ordering::Axes), 2.0 * runs(Ordering::Metis));
  }
}

TEST(Dissection, CutsAlongAxesTakeNoMoreWorkThanMetisWherePointsAreRegular) {
  for (const Rods& rods : {make_net(60, 60), make_net(90, 30), make_lattice(11)}) {
    const SymbolicAnalysis axes = analysis_of(rods, Ordering::Axes), points = analysis_of(rods, Ordering::Points);
    const double metis = analysis_of(rods, Ordering::Metis).flops;
    EXPECT_EQ(axes.ordering, Ordering::Axes);
    EXPECT_EQ(points.ordering, Ordering::Points);
    EXPECT_LE(axes.flops, metis);
    EXPECT_LE(points.flops, 1.7 * metis);
  }
}

TEST(Dissection, OrderIsChosenByFlopsAsFarAsLookingForItRepays) {
  const Rods net = make_net(120, 110), crumpled = make_crumpled_net(80), cloud = make_cloud(3000, 3);

  EXPECT_EQ(analysis_of(net, Ordering::Auto).ordering, Ordering::Axes);
  EXPECT_EQ(analysis_of(make_lattice(10), Ordering::Auto).ordering, Ordering::Axes);
  // This net is too light to look further than AMD.
  EXPECT_EQ(analysis_of(make_net(12, 12), Ordering::Auto).ordering, Ordering::Amd);

  const double of_amd = analysis_of(crumpled, Ordering::Amd, 0.0).flops;
  EXPECT_GE(analysis_of(crumpled, Ordering::Axes, 0.0).flops, 2.0 * of_amd);
  EXPECT_LE(analysis_of(crumpled, Ordering::Auto, 0.0).flops, of_amd);

  const SymbolicAnalysis of_cloud = analysis_of(cloud, Ordering::Auto, 0.0);
  EXPECT_TRUE(of_cloud.ordering == Ordering::Points || of_cloud.ordering == Ordering::Metis);
  EXPECT_LE(of_cloud.flops, 0.8 * analysis_of(cloud, Ordering::Axes, 0.0).flops);
}

TEST(Dissection, OnManyRowsAmdIsTriedWhereCutsAlongAxesAreBad) {
  const Rods net = make_net(320, 320), crumpled = make_crumpled_net(320), ladder = make_net(2, 80000);
  for (const Rods* const rods : {&net, &crumpled, &ladder})
    ASSERT_GE(pattern_of(*rods).size(), plan::rows_worth_axes_first);

  EXPECT_EQ(analysis_of(net, Ordering::Auto).ordering, Ordering::Axes);
  EXPECT_LE(analysis_of(crumpled, Ordering::Auto, 0.0).flops, analysis_of(crumpled, Ordering::Amd, 0.0).flops);
  EXPECT_LE(analysis_of(ladder, Ordering::Auto).flops, analysis_of(ladder, Ordering::Amd).flops);
}

TEST(Dissection, OrdersAreTheSameEveryTimeAndMetisServesWherePointsAreUnknown) {
  const Rods cloud = make_cloud(1000, 5);
  for (const Ordering wanted : {Ordering::Auto, Ordering::Axes, Ordering::Points}) {
    const SymbolicAnalysis once = analysis_of(cloud, wanted, 0.0);
    EXPECT_EQ(once.permutation, analysis_of(cloud, wanted, 0.0).permutation);
    const SymbolicAnalysis unknown = analyze(pattern_of(cloud), wanted);
    EXPECT_EQ(unknown.permutation, analyze(pattern_of(cloud), Ordering::Metis).permutation);
  }
}

}  // namespace
}  // namespace tanor
