/// Supernodes cost no more than those that CHOLMOD finds where it is built with its GPL modules.

#include <cholmod.h>
#include <gtest/gtest.h>

#include "factor/supernodes.hpp"
#include "patterns.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

/// Returns the supernodes of CHOLMOD's analysis in the given order.
Supernodes find_by_cholmod(const TrianglePattern& lower) {
  cholmod_common common;
  cholmod_start(&common);
  common.print = 0;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;
  cholmod_sparse view{};
  view.nrow = view.ncol = lower.size();
  view.nzmax = lower.rows.size();
  view.p = const_cast<int*>(lower.start.data());
  view.i = const_cast<int*>(lower.rows.data());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.sorted = view.packed = 1;
  cholmod_factor* factor = cholmod_analyze(&view, &common);
  Supernodes result;
  if (factor != nullptr && factor->is_super) {
    const int *first = static_cast<const int*>(factor->super), *start = static_cast<const int*>(factor->pi),
              *rows = static_cast<const int*>(factor->s);
    result = {{first, first + factor->nsuper + 1}, {start, start + factor->nsuper + 1}, {rows, rows + factor->ssize}};
  }
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  return result;
}

double flops_of(const Supernodes& supernodes) {
  double flops = 0.0;
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const int columns = supernodes.first_column[s + 1] - supernodes.first_column[s];
    for (int j = 0; j < columns; ++j) {
      const double below = static_cast<double>(supernodes.rows_start[s + 1] - supernodes.rows_start[s]) - j;
      flops += below * below;
    }
  }
  return flops;
}

class CholmodSupernodesTest : public testing::TestWithParam<std::pair<const char*, Rods>> {};

TEST_P(CholmodSupernodesTest, CostNoMoreThanThoseOfCholmod) {
  const Rods& rods = GetParam().second;
  for (const Ordering ordering : {Ordering::Amd, Ordering::Metis}) {
    const TrianglePattern lower = pattern_of(rods, analyze(pattern_of(rods), ordering).permutation);
    const Supernodes theirs = find_by_cholmod(lower);
    ASSERT_FALSE(theirs.first_column.empty());

    const Supernodes ours = find_supernodes(lower);

    // CHOLMOD merges more columns, and so has fewer supernodes with more zeros.
    EXPECT_LE(flops_of(ours), 1.01 * flops_of(theirs));
    EXPECT_LE(ours.num_stored(), theirs.num_stored());
    EXPECT_NEAR(static_cast<double>(ours.size()) / static_cast<double>(theirs.size()), 1.2, 0.2);
  }
}

INSTANTIATE_TEST_SUITE_P(All, CholmodSupernodesTest,
                         testing::Values(std::pair{"net", make_net(100, 100)}, std::pair{"small_net", make_net(24, 24)},
                                         std::pair{"lattice", make_lattice(12)},
                                         std::pair{"protein", make_protein(60, 1)},
                                         std::pair{"long_protein", make_protein(400, 2)}),
                         [](const auto& named) { return named.param.first; });

}  // namespace
}  // namespace tanor
