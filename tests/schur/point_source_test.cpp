/// Points that are brought on demand give the same bits as points that are there.

#include "base/point_source.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

#include "linearised.hpp"
#include "schur/composite_solver.hpp"

namespace tanor {
using namespace detail;
namespace {

/// Chains of so many rods. With `held` their first points are supports; with `rings` a further rod closes each. With
/// `trees` they are binary trees of as many rods instead.
struct Chains {
  const char* name;
  std::vector<std::size_t> lengths;
  bool held = false, rings = false, trees = false;
};

System make_system(const Chains& chains) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  System system;
  Rods rods;
  Support supports;
  for (const std::size_t length : chains.lengths) {
    const auto first = static_cast<Index>(system.masses.size()), last = first + static_cast<Index>(length);
    for (Index i = first; i <= last; ++i) {
      system.masses.push_back(1.0 + 0.1 * std::abs(normal(random)));
      for (int c = 0; c < 3; ++c) {
        system.positions.push_back(normal(random));
        system.velocities.push_back(normal(random));
      }
      if (i > first) rods.pairs.push_back({chains.trees ? first + (i - first - 1) / 2 : i - 1, i});
    }
    if (chains.rings) rods.pairs.push_back({last, first});
    if (chains.held) supports.points.push_back(first);
  }
  system.masses.push_back(1.0);  // a point by itself
  for (int c = 0; c < 3; ++c) {
    system.positions.push_back(normal(random));
    system.velocities.push_back(normal(random));
  }
  if (chains.held) system.supports.push_back(supports);
  system.constraints = {rods};
  return system;
}

using Arrays = std::vector<std::vector<double>*>;

/// Copies points and counts how often each came. Supports and separate points are there from the beginning.
class Copies final : public PointSource {
 public:
  Copies(const Arrays& from, const Arrays& to, std::size_t num_constrained) : from_(from), to_(to) {
    came.resize(from[0]->size() / 3);
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    for (std::size_t k = 0; k < from.size(); ++k) {
      *to[k] = *from[k];
      std::fill_n(to[k]->begin(), 3 * num_constrained, nan);
    }
  }
  void bring(std::size_t first, std::size_t count) const override {
    for (std::size_t k = 0; k < from_.size(); ++k)
      std::copy_n(from_[k]->begin() + 3 * static_cast<std::ptrdiff_t>(first), 3 * count,
                  to_[k]->begin() + 3 * static_cast<std::ptrdiff_t>(first));
    for (std::size_t i = first; i < first + count; ++i) ++came[i];
  }
  mutable std::vector<int> came;

 private:
  Arrays from_, to_;
};

class PointSources : public testing::TestWithParam<Chains> {};

TEST_P(PointSources, GiveTheSameBitsAsOneCallForAllPoints) {
  const System system = make_system(GetParam());
  const Linearised inner(system, 0.0, system.positions, system.velocities);
  const ReactionGather gather(inner.incidences, inner.numbering.num_points());
  const SchurProblem problem{inner.constraints, gather, inner.incidences, inner.numbering, inner.inverse_masses, {}};
  const std::size_t size = inner.r.size(), d = inner.constraints.num_rows(), num_blocks = inner.blocks.size();
  const std::size_t num_constrained = inner.numbering.num_moving - 1;
  std::vector<double> r = inner.r, v = inner.v, w0 = inner.v;
  std::fill(w0.begin() + static_cast<std::ptrdiff_t>(3 * inner.numbering.num_moving), w0.end(), 0.0);

  for (const int threads : {1, 2}) {
    CompositeSolver solver = make_composite_solver(problem, {.threads = threads});
    ASSERT_FALSE(solver.is_empty());
    const Parallel parallel(threads);
    std::vector<double> b(d), lambda(d), w = w0, blocks(num_blocks);
    (void)solver.solve(parallel, {r.data(), v.data(), w.data()}, FactorUse::Renew, blocks.data(), b.data(),
                       lambda.data(), w.data());

    std::vector<double> r2, v2, w2, b2(d), lambda2(d), blocks2(num_blocks);
    const Copies all({&r, &v, &w0}, {&r2, &v2, &w2}, num_constrained);
    const FreeMotion motion{.r = r2.data(), .v = v2.data(), .w0 = w2.data(), .source = &all};
    (void)solver.solve(parallel, motion, FactorUse::Renew, blocks2.data(), b2.data(), lambda2.data(), w2.data());
    EXPECT_EQ(lambda2, lambda);
    EXPECT_EQ(w2, w);
    EXPECT_EQ(blocks2, blocks);
    EXPECT_EQ(r2, r);
    EXPECT_GE(*std::min_element(all.came.begin(), all.came.begin() + static_cast<std::ptrdiff_t>(num_constrained)), 1);

    const Copies once_more({&r, &v, &w0}, {&r2, &v2, &w2}, num_constrained);
    w = w0;
    (void)solver.solve(parallel, {r.data(), v.data(), w.data()}, FactorUse::Keep, blocks.data(), b.data(),
                       lambda.data(), w.data());
    (void)solver.solve(parallel, {.r = r2.data(), .v = v2.data(), .w0 = w2.data(), .source = &once_more},
                       FactorUse::Keep, blocks2.data(), b2.data(), lambda2.data(), w2.data());
    EXPECT_EQ(lambda2, lambda);
    EXPECT_EQ(w2, w);

    const Copies places({&r}, {&r2}, num_constrained);
    std::fill(blocks2.begin(), blocks2.end(), 0.0);
    (void)solver.linearise(parallel, r2.data(), &places, blocks2.data());
    EXPECT_EQ(blocks2, blocks);
    EXPECT_EQ(r2, r);

    // The projections start from positions nearby, with a guess.
    std::vector<double> moved = r, sum(d, 1e-4), sum2(d, 1e-4), moved2;
    for (std::size_t k = 0; k < 3 * num_constrained; ++k) moved[k] += 1e-3 * v[k];
    const Copies moves({&moved}, {&moved2}, num_constrained);
    (void)solver.project_positions(parallel, blocks.data(), 1e-13, moved2.data(), &moves, sum2.data());
    (void)solver.project_positions(parallel, blocks.data(), 1e-13, moved.data(), nullptr, sum.data());
    EXPECT_EQ(moved2, moved);
    EXPECT_EQ(sum2, sum);
    ASSERT_EQ(moved.size(), size);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Chains, PointSources,
    testing::Values(Chains{"Batches", std::vector<std::size_t>(203, 40)},
                    Chains{"BatchesOnSupports", std::vector<std::size_t>(20, 7), true}, Chains{"Path", {10'001}},
                    Chains{"PathOnASupport", {10'000}, true}, Chains{"PathsInHalves", {9'000, 2, 1, 130, 257}},
                    Chains{"ShortPaths", {1, 2, 3, 4, 5}}, Chains{"ShortPathsOnSupports", {1, 2, 3, 4, 5}, true},
                    Chains{"Ring", {9'000}, false, true}, Chains{"Rings", {2, 9'000, 3, 5}, false, true},
                    Chains{"Trees", std::vector<std::size_t>(70, 510), false, false, true},
                    Chains{"TreesOnSupports", {510, 1022, 510, 254}, true, false, true}),
    [](const auto& instance) { return instance.param.name; });

}  // namespace
}  // namespace tanor
