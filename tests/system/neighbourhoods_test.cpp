/// Points are joined to neighbourhoods however they are numbered.

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "system/neighbourhoods.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Finds the sets by passing the least number on along each rod until nothing changes.
std::vector<Index> spread(const System& system) {
  std::vector<Index> least(system.num_points());
  std::iota(least.begin(), least.end(), 0);
  const auto& pairs = std::get<Rods>(system.constraints.front()).pairs;
  for (bool changes = true; changes;) {
    changes = false;
    for (const auto& [i, j] : pairs) {
      Index &of_i = least[static_cast<std::size_t>(i)], &of_j = least[static_cast<std::size_t>(j)];
      changes = changes || of_i != of_j;
      of_i = of_j = std::min(of_i, of_j);
    }
  }
  return least;
}

RC_GTEST_PROP(Neighbourhoods, RodsInAnyOrderJoinWhatTheyReach, ()) {
  const auto num_points = *rc::gen::inRange<Index>(2, 40);
  const auto num_rods = *rc::gen::inRange<std::size_t>(1, 40);
  System system;
  for (Index i = 0; i < num_points; ++i) system.positions.insert(system.positions.end(), {1.0 * i, 0.0, 0.0});
  system.masses.assign(static_cast<std::size_t>(num_points), 1.0);
  Rods rods;
  for (std::size_t a = 0; a < num_rods; ++a) {
    const auto i = *rc::gen::inRange<Index>(0, num_points), away = *rc::gen::inRange<Index>(1, num_points);
    rods.pairs.push_back({i, (i + away) % num_points});
  }
  system.constraints = {rods};

  const std::vector<Index> expected = spread(system);
  const Neighbourhoods found = find_neighbourhoods(system, 0.0);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j)
      RC_ASSERT((found.of_point[i] == found.of_point[j]) == (expected[i] == expected[j]));
  }
}

}  // namespace
}  // namespace tanor
