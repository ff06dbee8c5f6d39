/// Handles whose constraints come and go, and whose points get other numbers, are compared with new handles.

#include <gtest/gtest.h>

#include <numeric>
#include <thread>

#include "errors.hpp"
#include "host/edited_host.hpp"
#include "host/velocity_verlet.hpp"
#include "long_tests.hpp"

namespace tanor::host {
namespace {

constexpr double h = 1e-3;

/// Makes edits and, after each `every` of them, expects the bits of a new handle that has restored the edited one's
/// memory.
void edit_beside_fresh_handles(Edited* host, int edits, int every) {
  int good = 0;
  for (int k = 0; k < edits; ++k) {
    host->edit();
    if (k % every != 0) continue;
    Constrainer fresh = host->make_fresh();
    ASSERT_EQ(host->constrainer.num_rows(), host->rods.size());
    fresh.restore(host->constrainer.save());
    const Edited::Result own = host->step(&host->constrainer, h), other = host->step(&fresh, h);
    ASSERT_TRUE(own == other) << "after edit " << k;
    if (own.positions == Status::Ok && own.velocities == Status::Ok) {
      host->go_to(own);
      ++good;
    }
  }
  EXPECT_GT(good, edits / every * 9 / 10);
}

/// A handle that expects edits has the bits of a new handle that expects them, and pays for no first edit.
TEST(Topology, AHandleThatExpectsEditsHasTheBitsOfANewOne) {
  std::vector<double> r;
  const auto pairs = make_chains(1000, 20, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 8);
  host.constrainer.expect_edits();
  EXPECT_EQ(host.constrainer.update_plan(), 1000U);
  host.remove(7);
  EXPECT_LE(host.constrainer.update_plan(), 110U);
  for (int k = 0; k < 40; ++k) {
    host.edit();
    for (double& x : host.r) x += 0.125;  // no factor serves again
    Constrainer fresh = host.make_fresh();
    fresh.expect_edits();
    std::vector<double> w(r.size()), lambda(host.rods.size()), other_w = w, other_lambda = lambda;
    const std::vector<double> f(r.size(), 1.0);
    const auto solve = [&](Constrainer* by, std::vector<double>* to, std::vector<double>* multipliers) {
      const ConstraintReport report = by->solve({.positions = host.r,
                                                 .velocities = host.v,
                                                 .forces = f,
                                                 .accelerations = *to,
                                                 .wanted = {.multipliers = *multipliers}});
      EXPECT_TRUE(report.outcome.ok()) << report.outcome.what;
      return report.virial;
    };
    EXPECT_EQ(solve(&host.constrainer, &w, &lambda), solve(&fresh, &other_w, &other_lambda));
    ASSERT_EQ(w, other_w) << "after edit " << k;
    ASSERT_EQ(lambda, other_lambda) << "after edit " << k;
    std::vector<double> v = host.v, other_v = host.v;
    ASSERT_TRUE(host.constrainer.constrain_velocities({.positions = host.r, .velocities = v}).outcome.ok());
    ASSERT_TRUE(fresh.constrain_velocities({.positions = host.r, .velocities = other_v}).outcome.ok());
    ASSERT_EQ(v, other_v);
  }
}

TEST(Topology, FewChainsAfterEachEditAreThoseOfANewHandle) {
  std::vector<double> r;
  const auto pairs = make_chains(6, 12, &r);
  std::vector<double> masses(r.size() / 3, 1.0);
  masses[0] = masses[24] = infinity;
  Edited host(masses, r, pairs, 1);
  edit_beside_fresh_handles(&host, 10000, 1);
}

/// The system is cut into some parts, each of which has several islands.
TEST(Topology, ManyChainsAreThoseOfANewHandle) {
  std::vector<double> r;
  const auto pairs = make_chains(300, 12, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 2);
  edit_beside_fresh_handles(&host, tests_are_long() ? 6000 : 2000, 20);
}

/// A chain that is cut gives a piece to the part of the chains whose numbers lie beside those of the piece.
TEST(Topology, APieceOfALongChainJoinsThePartOfItsNumbers) {
  std::vector<double> r;
  std::vector<std::array<Index, 2>> pairs = make_chains(1, 1400, &r);
  const auto short_ones = make_chains(60, 12, &r);
  pairs.insert(pairs.end(), short_ones.begin(), short_ones.end());
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 14);
  host.constrainer.expect_edits();
  (void)host.constrainer.update_plan();
  host.remove(1099);
  Constrainer fresh = host.make_fresh();
  fresh.expect_edits();
  (void)host.step(&host.constrainer, h);  // makes the parts of both handles
  fresh.restore(host.constrainer.save());
  const Edited::Result own = host.step(&host.constrainer, h);
  EXPECT_EQ(own.positions, Status::Ok);
  EXPECT_TRUE(own == host.step(&fresh, h));
}

TEST(Topology, NetsAreThoseOfANewHandle) {
  std::vector<double> r;
  const auto pairs = make_nets(4, 16, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 3);
  edit_beside_fresh_handles(&host, 400, 10);
}

TEST(Topology, HasTheSameBitsWithOneAndTwoThreads) {
  std::vector<double> r;
  const auto pairs = make_chains(300, 12, &r);
  const std::vector<double> masses(r.size() / 3, 1.0);
  Edited one(masses, r, pairs, 4, 1), two(masses, r, pairs, 4, 2);
  for (int k = 0; k < 20; ++k) {
    one.edit();
    two.edit();
    const Edited::Result a = one.step(&one.constrainer, h), b = two.step(&two.constrainer, h);
    ASSERT_TRUE(a == b);
    one.go_to(a);
    two.go_to(b);
  }
}

TEST(Topology, AnEditPlansTheIslandsNearIt) {
  std::vector<double> r;
  const auto pairs = make_chains(1000, 20, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 5);
  EXPECT_EQ(host.constrainer.update_plan(), 1000U);
  host.remove(7);
  EXPECT_EQ(host.constrainer.update_plan(), 1001U);  // the first one cuts what was one part
  host.remove(100);
  EXPECT_LE(host.constrainer.update_plan(), 110U);
  EXPECT_EQ(host.constrainer.plan().islands, 1002U);
  EXPECT_EQ(host.constrainer.update_plan(), 0U);
}

/// The saved bytes tell into which parts a handle was cut.
TEST(Topology, ARestoredHandleHasTheSameParts) {
  std::vector<double> r;
  const auto pairs = make_chains(1000, 20, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 13);
  const std::vector<std::byte> whole = host.constrainer.save();
  Constrainer other = host.make_fresh();
  const ConstraintId last = static_cast<ConstraintId>(host.rods.size()) - 1;
  const double length = host.rods.back().length;
  const auto set_length = [&](Constrainer* constrainer) {
    constrainer->set_lengths({&last, 1}, {&length, 1});
    return constrainer->update_plan();
  };
  EXPECT_EQ(set_length(&host.constrainer), 1000U);
  other.restore(host.constrainer.save());
  EXPECT_LE(set_length(&other), 110U);
  EXPECT_TRUE(host.step(&host.constrainer, h) == host.step(&other, h));
  other.restore(whole);
  Constrainer fresh = host.make_fresh();
  fresh.restore(whole);
  EXPECT_TRUE(host.step(&fresh, h) == host.step(&other, h));
  EXPECT_EQ(set_length(&other), 1000U);
}

/// An edit keeps the guesses and factors of islands elsewhere.
TEST(Topology, IslandsElsewhereGoOn) {
  std::vector<double> r;
  const auto pairs = make_chains(1000, 20, &r);
  Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, 6), same = Edited(host.masses, r, pairs, 6);
  for (int k = 0; k < 3; ++k) {
    host.go_to(host.step(&host.constrainer, h));
    same.go_to(same.step(&same.constrainer, h));
  }
  // Both are cut at once, so that only the later edit makes a difference.
  host.set_mass(0, 2.0);
  same.set_mass(0, 2.0);
  host.go_to(host.step(&host.constrainer, h));
  same.go_to(same.step(&same.constrainer, h));
  host.remove(0);
  const Edited::Result edited = host.step(&host.constrainer, h), other = same.step(&same.constrainer, h);
  EXPECT_TRUE(std::equal(edited.r.begin() + 60, edited.r.end(), other.r.begin() + 60));
  EXPECT_TRUE(std::equal(edited.lambda.begin() + 18, edited.lambda.end(), other.lambda.begin() + 19));
}

TEST(Topology, RowsFollowTheIds) {
  std::vector<double> r;
  const auto pairs = make_chains(2, 4, &r);
  Constrainer constrainer(std::vector<double>(8, 1.0), {Rods{"rods", pairs, {}, {}}}, r);
  const ConstraintId wire = constrainer.add(Lines{"wire", {3}, Vector3{r[9], r[10], r[11]}, Vector3{1, 0, 0}});
  const ConstraintId last = constrainer.add(Rods{{}, {{0, 2}}, {}, {}});
  EXPECT_EQ(wire, 6);
  EXPECT_EQ(last, 7);
  EXPECT_EQ(constrainer.num_rows(), 9U);
  const std::vector<ConstraintId> two{1, 4};
  constrainer.remove(two);
  EXPECT_EQ(constrainer.num_rows(), 7U);
  EXPECT_EQ(constrainer.rows(wire).first, 4U);
  EXPECT_EQ(constrainer.rows(wire).count, 2U);
  EXPECT_EQ(constrainer.rows(last).first, 6U);
  EXPECT_EQ(constrainer.row_name(1), "rods[2]");
  EXPECT_EQ(constrainer.row_name(5), "wire[0].1");
  EXPECT_EQ(constrainer.row_name(6), "rod2[0]");
  std::vector<double> moved = r;
  moved[0] += 1e-3;
  const ConstraintReport report = constrainer.violation(moved);
  EXPECT_EQ(constrainer.row_name(report.worst_row), "rods[0]");
}

/// Both chains hang on one support, whose load is the sum of what they pull.
TEST(Topology, ASupportOfSeveralIslandsCarriesThemAll) {
  const std::vector<double> masses{infinity, 1.0, 2.0}, r{0, 0, 0, 0, 0, -1, 0, 0, -2}, v(9, 0.0);
  const std::vector<double> f{0, 0, 0, 0, 0, -10, 0, 0, -20};
  std::vector<double> forces(9), w(9);
  Constrainer constrainer(masses, {Rods{{}, {{0, 1}, {0, 2}}, {}, {}}}, r);
  const ConstraintReport report = constrainer.solve(
      {.positions = r, .velocities = v, .forces = f, .accelerations = w, .wanted = {.forces = forces}});
  ASSERT_TRUE(report.outcome.ok());
  EXPECT_NEAR(forces[2], -30.0, 1e-13);
  EXPECT_NEAR(forces[5], 10.0, 1e-13);
  EXPECT_NEAR(report.virial[2], -50.0, 1e-13);
}

TEST(Lengths, DragThePointsAlongAsTheyGrow) {
  const std::vector<double> masses{infinity, 1.0};
  std::vector<double> r{0, 0, 0, 0, 0, -1}, v(6, 0.0);
  Constrainer constrainer(masses, {Rods{{}, {{0, 1}}, {}, {}}}, r);
  const ConstraintId id = 0;
  const double rate = 0.25;
  for (int k = 1; k <= 10; ++k) {
    const double length = 1.0 + rate * h * k;
    constrainer.set_lengths({&id, 1}, {&length, 1}, {&rate, 1});
    EXPECT_EQ(constrainer.update_plan(), k == 1 ? 1U : 0U);
    const std::vector<double> old = r;
    ASSERT_TRUE(constrainer.constrain_positions({.step = h, .old_positions = old, .positions = r}).outcome.ok());
    EXPECT_NEAR(r[5], -length, 1e-13);
    ASSERT_TRUE(constrainer.constrain_velocities({.step = h, .positions = r, .velocities = v}).outcome.ok());
    EXPECT_NEAR(v[5], -rate, 1e-13);
  }
}

/// An edited handle in a cell is compared with a new one, wherever its points are wrapped.
TEST(Topology, AnEditedHandleInACellIsAsANewOne) {
  const PeriodicCell cell{.edges = {{{7, 0, 0}, {0.5, 6, 0}, {0, 0, 7}}}};
  std::vector<double> r;
  auto pairs = make_chains(3, 10, &r);
  for (std::size_t k = 0; k < r.size(); k += 3) r[k] -= 7.0 * std::floor(r[k] / 7.0);
  const std::vector<double> masses(r.size() / 3, 1.0);
  Constrainer constrainer(masses, {Rods{{}, pairs, {}, {}}}, r, {.cell = cell});
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  std::vector<double> v(r.size()), other_v(r.size());
  for (double& x : v) x = normal(random);
  const std::vector<ConstraintId> gone{4, 13, 20};
  constrainer.remove(gone);
  constrainer.add(Rods{{}, {{9, 19}}, 2.7, {}}, r);
  for (const std::size_t k : {20U, 13U, 4U}) pairs.erase(pairs.begin() + static_cast<std::ptrdiff_t>(k));
  pairs.push_back({9, 19});
  std::vector<double> put_right = r;
  ASSERT_TRUE(constrainer.project_positions(put_right).outcome.ok());
  Constrainer fresh(masses, {Rods{{}, pairs, {}, {}}}, put_right, {.cell = cell});
  other_v = v;
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = put_right, .velocities = v}).outcome.ok());
  ASSERT_TRUE(fresh.constrain_velocities({.positions = put_right, .velocities = other_v}).outcome.ok());
  for (std::size_t k = 0; k < v.size(); ++k) EXPECT_NEAR(v[k], other_v[k], 1e-12);
  EXPECT_NEAR(fresh.violation(put_right).violation, 0.0, 1e-15);
}

// ---- numbers ----

/// A twin that keeps its numbers has the same bits of the motion.
TEST(Renumbering, ChangesNoBitOfTheMotion) {
  std::vector<double> r;
  const auto pairs = make_chains(40, 10, &r);
  const std::size_t n = r.size() / 3;
  Edited twin(std::vector<double>(n, 1.0), r, pairs, 7);
  Constrainer constrainer(twin.masses, {Rods{{}, pairs, {}, {}}}, r, {.threads = 1});
  std::vector<std::int64_t> numbers(n);  // [now] of the twin
  std::iota(numbers.begin(), numbers.end(), 0);
  std::mt19937 random(8);
  for (int turn = 0; turn < 10; ++turn) {
    std::vector<std::int64_t> from(n), next(n);
    std::iota(from.begin(), from.end(), 0);
    std::shuffle(from.begin(), from.end(), random);
    std::vector<Index> place(n);
    for (std::size_t i = 0; i < n; ++i) next[i] = numbers[static_cast<std::size_t>(from[i])];
    numbers = next;
    constrainer.renumber(from, twin.masses);
    EXPECT_EQ(constrainer.update_plan(), 0U);

    const Edited::Result wanted = twin.step(&twin.constrainer, h);
    Edited renumbered = Edited(twin.masses, twin.r, pairs, 9);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        renumbered.r[3 * i + k] = twin.r[3 * static_cast<std::size_t>(numbers[i]) + k];
        renumbered.v[3 * i + k] = twin.v[3 * static_cast<std::size_t>(numbers[i]) + k];
      }
    }
    const Edited::Result own = renumbered.step(&constrainer, h);
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < 3; ++k)
        ASSERT_EQ(own.r[3 * i + k], wanted.r[3 * static_cast<std::size_t>(numbers[i]) + k]);
    }
    EXPECT_EQ(own.lambda, wanted.lambda);
    twin.go_to(wanted);
  }
}

/// A dumbbell leaves, and another one comes under the numbers of the first.
TEST(Renumbering, PointsLeaveAndCome) {
  std::vector<double> r{0, 0, 0, 1, 0, 0, 5, 0, 0, 5, 2, 0};
  Constrainer constrainer(std::vector<double>(4, 1.0), {Rods{{}, {{0, 1}, {2, 3}}, {}, {}}}, r);
  const std::vector<std::int64_t> from{2, 3, -1, -1, -1};
  const std::vector<double> masses{1.0, 1.0, 3.0, 1.0, infinity};
  EXPECT_NE(error_of([&] { constrainer.renumber(from, masses); }).find("rod0[0] still holds point 0"),
            std::string::npos);
  const ConstraintId first = 0;
  constrainer.remove({&first, 1});
  r = {5, 0, 0, 5, 2, 0, 7, 7, 7, 7, 7, 8, 7, 7, 10};
  constrainer.renumber(from, masses, r);
  EXPECT_EQ(constrainer.num_points(), 5U);
  constrainer.add(Rods{{}, {{2, 3}, {3, 4}}, {}, {}});

  std::vector<double> v{0, 1, 0, 0, 3, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = r, .velocities = v}).outcome.ok());

  EXPECT_NEAR(v[1], 2.0, 1e-14);
  EXPECT_NEAR(v[4], 2.0, 1e-14);
  for (const std::size_t k : {8U, 11U}) EXPECT_NEAR(v[k], 0.0, 1e-14);
}

/// The saved memory of a handle whose points got other numbers fits a handle that never had the old ones.
TEST(Renumbering, IsSavedWithTheHandle) {
  std::vector<double> r;
  const auto pairs = make_chains(5, 8, &r);
  const std::size_t n = r.size() / 3;
  Edited host(std::vector<double>(n, 1.0), r, pairs, 10);
  for (int k = 0; k < 3; ++k) host.go_to(host.step(&host.constrainer, h));
  std::vector<std::int64_t> back(n);
  for (std::size_t i = 0; i < n; ++i) back[i] = static_cast<std::int64_t>(n - 1 - i);
  host.constrainer.renumber(back, host.masses);
  Edited other = Edited(host.masses, host.r, pairs, 10);
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      other.r[3 * i + k] = host.r[3 * (n - 1 - i) + k];
      other.v[3 * i + k] = host.v[3 * (n - 1 - i) + k];
    }
  }
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    other.rods[k].i = static_cast<Index>(n) - 1 - pairs[k][0];
    other.rods[k].j = static_cast<Index>(n) - 1 - pairs[k][1];
    other.rods[k].length = host.rods[k].length;
  }
  Constrainer fresh = other.make_fresh();
  fresh.restore(host.constrainer.save());
  EXPECT_TRUE(other.step(&host.constrainer, h) == other.step(&fresh, h));
}

// ---- errors ----

TEST(TopologyErrors, LeaveTheHandleAsItWas) {
  std::vector<double> r;
  const auto pairs = make_chains(2, 4, &r);
  std::vector<double> masses(8, 1.0);
  masses[0] = infinity;
  Constrainer constrainer(masses, {Rods{"rods", pairs, {}, {}}}, r);
  const auto error = [&](const auto& edit) { return error_of([&] { edit(); }); };
  const std::vector<ConstraintId> unknown{1, 17}, twice{2, 2}, one{1};
  const std::vector<double> lengths{1.0, 1.0}, wrong{-1.0}, length{1.0};
  EXPECT_EQ(error([&] { constrainer.remove(unknown); }), "there is no constraint with the id 17");
  EXPECT_EQ(error([&] { constrainer.remove(twice); }), "the constraint with the id 2 is removed twice");
  EXPECT_EQ(error([&] { constrainer.set_lengths(unknown, lengths); }), "there is no constraint with the id 17");
  EXPECT_NE(error([&] { constrainer.set_lengths(one, wrong); }).find("not positive"), std::string::npos);
  EXPECT_NE(error([&] { constrainer.set_lengths(one, lengths); }).find("lengths has 2"), std::string::npos);
  const std::vector<Index> first{0}, second{1}, none{8};
  const std::vector<double> infinite{infinity};
  EXPECT_NE(error([&] { constrainer.set_masses(second, infinite); }).find("become a support"), std::string::npos);
  EXPECT_NE(error([&] { constrainer.set_masses(first, length); }).find("infinite mass"), std::string::npos);
  EXPECT_NE(error([&] { constrainer.set_masses(second, wrong); }).find("not positive"), std::string::npos);
  const std::vector<double> least{5e-324};
  EXPECT_EQ(error([&] { constrainer.set_masses(second, least); }), "/masses/1: mass 5e-324 is below 1e-100");
  EXPECT_NE(error([&] { constrainer.set_masses(none, length); }).find("no point 8"), std::string::npos);
  EXPECT_NE(error([&] { (void)constrainer.add(Rods{"rods", {{0, 2}}, {}, {}}); }).find("used once"), std::string::npos);
  EXPECT_NE(error([&] {
              (void)constrainer.add(Rods{{}, {{3, 3}}, {}, {}});
            }).find("names point 3 twice"),
            std::string::npos);
  EXPECT_NE(error([&] {
              (void)constrainer.add(Rods{{}, {{3, 8}}, {}, {}});
            }).find("point 8 is out of range"),
            std::string::npos);
  EXPECT_EQ(constrainer.num_rows(), 6U);
  EXPECT_EQ(constrainer.update_plan(), 0U);
  constrainer.remove(one);
  EXPECT_EQ(error([&] { constrainer.remove(one); }), "there is no constraint with the id 1; it was removed");
}

TEST(TopologyErrors, BytesOfAnotherHandleAreRefused) {
  std::vector<double> r;
  const auto pairs = make_chains(2, 4, &r);
  const std::vector<double> masses(8, 1.0);
  Constrainer constrainer(masses, {Rods{"rods", pairs, {}, {}}}, r), other(masses, {Rods{{}, pairs, {}, {}}}, r);
  std::vector<std::byte> bytes = constrainer.save();
  other.restore(bytes);
  std::vector<std::byte> earlier = bytes;
  earlier[8] = std::byte{1};
  EXPECT_EQ(error_of([&] { other.restore(earlier); }), "/state: its format is 1, this version of tanor reads 2");
  const ConstraintId id = 3;
  other.remove({&id, 1});
  EXPECT_EQ(error_of([&] { other.restore(bytes); }), "/state: it belongs to other points or constraints");
  bytes[40] ^= std::byte{1};
  EXPECT_NE(error_of([&] { constrainer.restore(bytes); }).find("damaged"), std::string::npos);
  bytes.resize(10);
  EXPECT_NE(error_of([&] { constrainer.restore(bytes); }).find("too early"), std::string::npos);
}

/// This test is for the thread sanitizer.
TEST(Handles, AreEditedInTwoThreads) {
  const auto run = [](unsigned seed, Edited::Result* result) {
    std::vector<double> r;
    const auto pairs = make_chains(60, 10, &r);
    Edited host(std::vector<double>(r.size() / 3, 1.0), r, pairs, seed);
    for (int k = 0; k < 40; ++k) {
      host.edit();
      *result = host.step(&host.constrainer, h);
    }
  };
  Edited::Result alone, first, second;
  run(11, &alone);
  std::thread one([&] { run(11, &first); }), two([&] { run(12, &second); });
  one.join();
  two.join();
  EXPECT_TRUE(first == alone);
}

}  // namespace
}  // namespace tanor::host
