/// The calls find the same bits however a host stores its points and however many threads work on them.

#include <gtest/gtest.h>
#include <tanor/user_kernel.hpp>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <numeric>
#include <random>
#include <stdexcept>

#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

/// `count` crumpled chains of `length` rods, each point after the one before it.
struct Chains {
  std::size_t count, length;
};

struct State {
  std::vector<double> masses, r, v, f;
  Rods rods{"rods", {}, {}, {}};

  explicit State(const Chains& chains) {
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    for (std::size_t k = 0; k < chains.count; ++k) {
      for (std::size_t i = 0; i <= chains.length; ++i) {
        const double d[3]{normal(random), normal(random), normal(random)}, size = std::hypot(d[0], d[1], d[2]);
        for (std::size_t c = 0; c < 3; ++c) {
          r.push_back(i == 0 ? 0.0 : r[r.size() - 3] + d[c] / size);
          v.push_back(normal(random));
          f.push_back(normal(random));
        }
        masses.push_back(1.0 + std::abs(normal(random)));
        const auto point = static_cast<Index>(masses.size()) - 1;
        if (i > 0) rods.pairs.push_back({point - 1, point});
      }
    }
  }
};

/// Places of the host's points in its arrays, by their numbers.
struct Storage {
  std::vector<Index> index;  // empty: where they are

  std::vector<double> put(const std::vector<double>& x) const {
    std::vector<double> result = x;
    for (std::size_t i = 0; i < index.size(); ++i)
      std::copy_n(&x[3 * i], 3, &result[3 * static_cast<std::size_t>(index[i])]);
    return result;
  }
  std::vector<double> take(const std::vector<double>& x) const {
    std::vector<double> result = x;
    for (std::size_t i = 0; i < index.size(); ++i)
      std::copy_n(&x[3 * static_cast<std::size_t>(index[i])], 3, &result[3 * i]);
    return result;
  }
  PointArray array(std::vector<double>* x) const { return {x->data(), 0, index.empty() ? nullptr : index.data()}; }
};

/// Returns all that two steps, a solve, a projection of forces and a start write.
std::vector<std::vector<double>> run(const State& state, const Storage& storage, int threads) {
  const double h = 1e-3;
  std::vector<double> old = storage.put(state.r), r = old, v = storage.put(state.v), f = storage.put(state.f), w = r,
                      eta = r, lambda(state.rods.pairs.size());
  Constrainer constrainer(state.masses, {state.rods}, storage.array(&r), {.threads = threads});
  std::vector<std::vector<double>> result;
  for (int step = 0; step < 2; ++step) {
    old = r;
    for (std::size_t k = 0; k < r.size(); ++k) r[k] += h * v[k];
    const ConstraintReport moved =
        constrainer.constrain_positions({.step = h,
                                         .old_positions = storage.array(&old),
                                         .positions = storage.array(&r),
                                         .velocities = storage.array(&v),
                                         .wanted = {.multipliers = lambda, .forces = storage.array(&eta)}});
    EXPECT_TRUE(moved.outcome.ok()) << moved.outcome.what;
    result.insert(result.end(), {storage.take(r), storage.take(v), lambda, storage.take(eta)});
    const ConstraintReport turned =
        constrainer.constrain_velocities({.step = h, .positions = storage.array(&r), .velocities = storage.array(&v)});
    EXPECT_TRUE(turned.outcome.ok()) << turned.outcome.what;
    result.push_back({moved.correction, moved.violation, moved.largest_turn, turned.correction, turned.violation});
    result.push_back(storage.take(v));
  }
  const ConstraintReport solved = constrainer.solve({.positions = storage.array(&r),
                                                     .velocities = storage.array(&v),
                                                     .forces = storage.array(&f),
                                                     .accelerations = storage.array(&w),
                                                     .wanted = {.multipliers = lambda}});
  EXPECT_TRUE(solved.outcome.ok()) << solved.outcome.what;
  result.insert(result.end(), {storage.take(w), lambda, {solved.violation}});
  result.emplace_back(solved.virial.begin(), solved.virial.end());
  const ConstraintReport projected =
      constrainer.project_forces(storage.array(&r), storage.array(&f), 0.0, {.multipliers = lambda});
  EXPECT_TRUE(projected.outcome.ok()) << projected.outcome.what;
  result.insert(result.end(), {storage.take(f), lambda, {projected.correction, projected.violation}});
  result.emplace_back(projected.virial.begin(), projected.virial.end());
  for (std::size_t k = 0; k < r.size(); ++k) r[k] += 20.0 * h * v[k];
  const ConstraintReport put_right = constrainer.project_positions(storage.array(&r));
  EXPECT_TRUE(put_right.outcome.ok()) << put_right.outcome.what;
  result.insert(result.end(), {storage.take(r), {put_right.correction, put_right.violation, put_right.largest_turn}});
  return result;
}

class Arrays : public testing::TestWithParam<Chains> {};

TEST_P(Arrays, GiveTheSameBitsInAnyOrderOnAnyThreads) {
  const State state(GetParam());
  Storage same, shuffled;
  same.index.resize(state.masses.size());
  std::iota(same.index.begin(), same.index.end(), 0);
  shuffled = same;
  std::ranges::shuffle(shuffled.index, std::mt19937(5));
  const std::vector<std::vector<double>> straight = run(state, {}, 1);

  for (const Storage& storage : {Storage{}, same, shuffled}) {
    for (const int threads : {1, 2}) {
      const std::vector<std::vector<double>> other = run(state, storage, threads);
      ASSERT_EQ(other.size(), straight.size());
      for (std::size_t k = 0; k < other.size(); ++k)
        EXPECT_EQ(other[k], straight[k]) << "array " << k << ", " << threads << " threads";
    }
  }
}

/// Rods that depend on others leave the islands' own iterations to the factor of all rows.
TEST(PointArrays, GiveTheSameBitsOnAnyThreadsWhereRodsDependOnOthers) {
  State state(Chains{1, 10'001});
  const auto first = static_cast<Index>(state.masses.size());
  for (const double x : {12.0, 1.0, 1.5, 2.0, 3.0}) state.masses.push_back(x);
  state.r.insert(state.r.end(), {0, 0, 0, 1, 1, 1, 1, -1, -1, -1, 1, -1, -1, -1, 1});
  for (std::size_t k = 0; k < 15; ++k) state.v.push_back(std::sin(static_cast<double>(k)));
  for (const auto& [i, j] : make_all_distances(5).pairs) state.rods.pairs.push_back({first + i, first + j});
  std::vector<std::vector<double>> velocities, multipliers;
  for (const int threads : {1, 2, 3}) {
    Constrainer constrainer(state.masses, {state.rods}, state.r, {.threads = threads});
    velocities.push_back(state.v);
    multipliers.emplace_back(state.rods.pairs.size());
    const ConstraintReport report = constrainer.constrain_velocities(
        {.positions = state.r, .velocities = velocities.back(), .wanted = {.multipliers = multipliers.back()}});
    ASSERT_TRUE(report.outcome.ok()) << report.outcome.what;
    EXPECT_EQ(velocities.back(), velocities.front());
    EXPECT_EQ(multipliers.back(), multipliers.front());
  }
  EXPECT_GT(std::abs(multipliers.front().front()), 1e-3);
}

/// Returns the bits of an array, in which NaN is like NaN.
std::vector<std::uint64_t> bits(const std::vector<double>& x) {
  std::vector<std::uint64_t> result(x.size());
  std::ranges::transform(x, result.begin(), [](double number) { return std::bit_cast<std::uint64_t>(number); });
  return result;
}

/// The last chain fails when the others have moved. Points that follow one another move where the host has them.
TEST_P(Arrays, AreWhatTheyWereAfterAFailure) {
  const State state(GetParam());
  const double h = 1e-3, nan = std::numeric_limits<double>::quiet_NaN();
  Storage shuffled;
  shuffled.index.resize(state.masses.size());
  std::iota(shuffled.index.begin(), shuffled.index.end(), 0);
  std::ranges::shuffle(shuffled.index, std::mt19937(5));
  for (const Storage& storage : {Storage{}, shuffled}) {
    for (const bool is_cut : {false, true}) {
      std::vector<double> old = storage.put(state.r), r = state.r, v = state.v;
      for (std::size_t k = 0; k < r.size(); ++k) r[k] += h * v[k];
      r.back() += 1e3;
      r = storage.put(r);
      v = storage.put(v);
      Constrainer constrainer(state.masses, {state.rods}, storage.array(&old));
      if (is_cut) constrainer.expect_edits();
      const std::vector<std::uint64_t> r_before = bits(r), v_before = bits(v);
      const ConstraintReport moved = constrainer.constrain_positions({.step = h,
                                                                      .old_positions = storage.array(&old),
                                                                      .positions = storage.array(&r),
                                                                      .velocities = storage.array(&v)});
      EXPECT_EQ(moved.outcome.status, Status::NotConverged) << moved.outcome.what;
      EXPECT_EQ(bits(r), r_before);
      EXPECT_EQ(bits(v), v_before);

      std::vector<double> broken = state.v;
      broken.back() = nan;
      broken = storage.put(broken);
      const std::vector<std::uint64_t> broken_before = bits(broken);
      const ConstraintReport turned = constrainer.constrain_velocities(
          {.step = h, .positions = storage.array(&old), .velocities = storage.array(&broken)});
      EXPECT_EQ(turned.outcome.status, Status::NotFinite) << turned.outcome.what;
      EXPECT_EQ(bits(broken), broken_before);
    }
  }
}

/// A function of the host throws in one part when points of another part have moved in place.
TEST(PointArrays, AreWhatTheyWereAfterAFunctionThrows) {
  const State state(Chains{1, 3000});  // a part of its own
  std::vector<double> masses = state.masses, old = state.r;
  const auto first = static_cast<Index>(masses.size());
  masses.insert(masses.end(), {1.0, 1.0});
  old.insert(old.end(), {50.0, 0.0, 0.0, 51.0, 0.0, 0.0});
  bool throws = false;
  const UserConstraints gear{"gear", {{first, first + 1}}, make_constraint_kernel<2>([&](const auto& x, const auto&) {
                               if (throws) throw std::runtime_error("enough");
                               return x[3] - x[0] - 1.0;
                             })};
  Constrainer constrainer(masses, {state.rods, gear}, PointArray{old.data()}, {.threads = 1});
  constrainer.expect_edits();
  ASSERT_TRUE(constrainer.violation(PointArray{old.data()}).outcome.ok());
  std::vector<double> r = old;
  for (std::size_t k = 0; k < state.v.size(); ++k) r[k] += 1e-3 * state.v[k];
  const std::vector<std::uint64_t> before = bits(r);
  const PositionStep step{.step = 1e-3, .old_positions = PointArray{old.data()}, .positions = PointArray{r.data()}};
  throws = true;
  EXPECT_THROW((void)constrainer.constrain_positions(step), std::runtime_error);
  EXPECT_EQ(bits(r), before);
  throws = false;
  EXPECT_TRUE(constrainer.constrain_positions(step).outcome.ok());
  EXPECT_NE(bits(r), before);
}

INSTANTIATE_TEST_SUITE_P(Chains, Arrays,
                         testing::Values(Chains{1, 3}, Chains{103, 60}, Chains{1, 10'001}, Chains{3, 3000}),
                         [](const auto& instance) {
                           return std::to_string(instance.param.count) + "x" + std::to_string(instance.param.length);
                         });

}  // namespace
}  // namespace tanor::host
