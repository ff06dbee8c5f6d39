/// Supernodes agree with the dense pattern of L.

#include "factor/supernodes.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

/// Makes rods between random points, sparse or dense.
Rods make_random_rods(int num_points, int count, std::uint32_t seed) {
  std::mt19937 generator(seed);
  Rods rods{num_points, {}};
  std::uniform_int_distribution<int> any(0, num_points - 1);
  for (int k = 0; k < count; ++k) rods.ends.emplace_back(any(generator), any(generator));
  return rods;
}

/// Returns [column][row] of L by elimination.
std::vector<std::vector<bool>> fill_in(const TrianglePattern& lower) {
  const std::size_t n = lower.size();
  std::vector<std::vector<bool>> L(n, std::vector<bool>(n, false));
  for (std::size_t j = 0; j < n; ++j) {
    for (int e = lower.start[j]; e < lower.start[j + 1]; ++e)
      L[j][static_cast<std::size_t>(lower.rows[static_cast<std::size_t>(e)])] = true;
  }
  for (std::size_t j = 0; j < n; ++j) {
    for (std::size_t k = j + 1; k < n; ++k) {
      if (!L[j][k]) continue;
      for (std::size_t i = k; i < n; ++i) L[k][i] = L[k][i] || L[j][i];
    }
  }
  return L;
}

std::vector<int> rows_of(const Supernodes& supernodes, std::size_t s) {
  return {supernodes.rows.begin() + static_cast<std::ptrdiff_t>(supernodes.rows_start[s]),
          supernodes.rows.begin() + static_cast<std::ptrdiff_t>(supernodes.rows_start[s + 1])};
}

RC_GTEST_PROP(Supernodes, HoldTheRowsOfTheirColumnsAndNoOthers, ()) {
  const int points = *rc::gen::inRange(1, 30).as("points");
  const Rods rods = make_random_rods(points, *rc::gen::inRange(0, 60).as("rods"), *rc::gen::arbitrary<std::uint32_t>());
  const auto ordering = *rc::gen::element(Ordering::Natural, Ordering::Amd, Ordering::Metis);
  const TrianglePattern lower = pattern_of(rods, analyze(pattern_of(rods), ordering).permutation);
  const std::vector<std::vector<bool>> L = fill_in(lower);

  const Supernodes supernodes = find_supernodes(lower);

  RC_ASSERT(supernodes.first_column.front() == 0);
  RC_ASSERT(supernodes.first_column.back() == static_cast<int>(lower.size()));
  double stored = 0.0;
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const int first = supernodes.first_column[s], end = supernodes.first_column[s + 1];
    RC_ASSERT(end > first);
    std::vector<int> wanted;
    for (int i = first; i < static_cast<int>(lower.size()); ++i) {
      bool is_there = i < end;
      for (int j = first; j < end; ++j)
        is_there = is_there || L[static_cast<std::size_t>(j)][static_cast<std::size_t>(i)];
      if (is_there) wanted.push_back(i);
    }
    RC_ASSERT(rows_of(supernodes, s) == wanted);
    for (int j = 0; j < end - first; ++j) stored += static_cast<double>(wanted.size()) - j;
  }
  RC_ASSERT(supernodes.num_stored() == stored);
}

}  // namespace
}  // namespace tanor
