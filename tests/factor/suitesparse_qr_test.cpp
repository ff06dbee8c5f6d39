/// SuiteSparseQR is the reference of the QR by fronts, whichever of them the library was built with.

#include "factor/sparse_qr.hpp"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "factor/rank_solver.hpp"
#include "molecule.hpp"
#include "patterns.hpp"
#include "scene/text_file.hpp"

namespace tanor {
using namespace detail;
namespace {

using namespace patterns;

/// Makes a net in a plane, braced at random, with many redundant diagonals.
Rods make_braced_net(int side, std::uint32_t seed) {
  std::mt19937 generator(seed);
  Rods rods = make_net(side, side);
  for (int i = 0; i + 1 < side; ++i) {
    for (int j = 0; j + 1 < side; ++j) {
      const int corner = i * side + j;
      if (generator() % 3 != 0) rods.ends.emplace_back(corner, corner + side + 1);
      if (generator() % 2 != 0) rods.ends.emplace_back(corner + 1, corner + side);
    }
  }
  std::shuffle(rods.ends.begin(), rods.ends.end(), generator);
  return rods;
}

std::vector<int> names_of(const RankSolver& solver) {
  std::vector<int> names;
  for (const Dependence& dependence : solver.dependences()) {
    names.push_back(dependence.column);
    const auto first = static_cast<std::ptrdiff_t>(names.size());
    for (const Dependence::Term& term : dependence.terms) names.push_back(term.column);
    std::sort(names.begin() + first, names.end());
  }
  return names;
}

double largest_coefficient(const RankSolver& solver) {
  double largest = 0.0;
  for (const Dependence& dependence : solver.dependences()) {
    if (!dependence.terms.empty()) largest = std::max(largest, std::abs(dependence.terms.front().coefficient));
  }
  return largest;
}

RC_GTEST_PROP(SuiteSparseQr, FindsTheRankAndTheRedundantRodsThatFrontsFind, ()) {
  const auto seed = *rc::gen::arbitrary<std::uint32_t>().as("seed");
  const bool is_molecule = *rc::gen::arbitrary<bool>().as("molecule");
  const bool is_flat = !is_molecule && *rc::gen::arbitrary<bool>().as("flat");
  const Rods rods =
      is_molecule ? make_protein(*rc::gen::inRange(1, 12), seed) : make_braced_net(*rc::gen::inRange(2, 9), seed);
  const SparseColumns C = gradients_of(rods, seed, is_flat);

  const RankSolver ours(C, 0.0, factorize_by_fronts), theirs(C, 0.0, factorize_with_suitesparse);

  RC_ASSERT(ours.rank() == theirs.rank());
  RC_ASSERT(ours.unique() == theirs.unique());
  if (!is_flat) RC_ASSERT(names_of(ours) == names_of(theirs));
  // Nets in a plane may be so crooked that rounding chooses where the exchange of rods begins. It ends at sets that are
  // equally good.
  RC_ASSERT(largest_coefficient(ours) <= 2.0 + 1e-6);
  RC_ASSERT(largest_coefficient(theirs) <= 2.0 + 1e-6);
}

#ifdef TANOR_PROTEIN  // the file could be fetched
// The molecule has 892 atoms, 906 bonds and 1626 angles. A dense singular value decomposition finds the rank with a gap
// of 3e8.
TEST(SuiteSparseQr, NamesTheSame173RedundantRowsOfBptiAsFronts) {
  const SparseColumns C = gradients_of(scene::read_lammps_data(TANOR_PROTEIN, scene::read_text(TANOR_PROTEIN)));

  const RankSolver ours(C, 0.0, factorize_by_fronts), theirs(C, 0.0, factorize_with_suitesparse);

  EXPECT_EQ(ours.rank(), 2359u);
  EXPECT_EQ(theirs.rank(), 2359u);
  EXPECT_EQ(ours.dependences().size(), 173u);
  EXPECT_EQ(names_of(ours), names_of(theirs));
  EXPECT_EQ(ours.unique(), theirs.unique());
}
#endif

TEST(SuiteSparseQr, FillsNoLessThanFronts) {
  for (const Rods& rods : {make_net(60, 60), make_lattice(10), make_protein(200, 3)}) {
    const SparseColumns C = gradients_of(rods, 1);
    const double ours = static_cast<double>(factorize_by_fronts(C, 1e-11).values.size()),
                 theirs = static_cast<double>(factorize_with_suitesparse(C, 1e-11).values.size());
    EXPECT_LE(ours, 1.05 * theirs);
  }
}

}  // namespace
}  // namespace tanor
