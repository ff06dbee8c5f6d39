/// The tests make every call of <tanor.h> beside those of the Constrainer: what it reads, what it writes, and how it
/// fails.

#include <gtest/gtest.h>
#include <tanor.h>
#include <tanor/velocity_verlet.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "host/c_handle.hpp"
#include "measures.hpp"
#include "scenes.hpp"

namespace tanor::host {
namespace {

tn_const_points read_of(const std::vector<double>& array) {
  return {array.data(), 0, nullptr};
}
tn_points write_to(std::vector<double>& array) {
  return {array.data(), 0, nullptr};
}
tn_report empty_report() {
  tn_report report{};
  report.size = sizeof(report);
  return report;
}

void expect_same(const tn_report& c, const ConstraintReport& report) {
  EXPECT_EQ(c.iterations, report.iterations);
  EXPECT_EQ(c.violation, report.violation);
  EXPECT_EQ(c.correction, report.correction);
  EXPECT_EQ(c.worst_row, report.worst_row == ConstraintReport::no_row ? -1 : static_cast<int64_t>(report.worst_row));
  EXPECT_EQ(c.largest_turn, report.largest_turn);
  EXPECT_EQ(c.work, report.work);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(c.virial[k], report.virial[k]) << k;
}

std::string last_error(const Handle& handle) {
  return tn_last_error(handle.get());
}

TEST(CCalls, TheAbiIsThatOfTheHeader) {
  EXPECT_EQ(tn_abi(), TN_ABI);
}

TEST(CCalls, SolvesAsTheConstrainer) {
  const Tailed host;
  const Handle handle = host.make_handle();
  Constrainer constrainer = host.make_constrainer();
  const std::vector<double> f{3, -1, 2, 0.5, 4, -2, 1, 1, -3, 2, -2, 0.25};
  std::vector<double> w(12), c_w(12), lambda(4), c_lambda(4), forces(12), c_forces(12), stress(36), c_stress(36);
  const tn_wanted wanted{sizeof(tn_wanted), 1, c_lambda.data(), write_to(c_forces), write_to(c_stress)};
  tn_report c_report = empty_report();

  const ConstraintReport report =
      constrainer.solve({.positions = host.r,
                         .velocities = host.v,
                         .forces = f,
                         .accelerations = w,
                         .wanted = {.multipliers = lambda, .forces = forces, .stress = stress}});
  ASSERT_EQ(tn_solve(handle.get(), read_of(host.r), read_of(host.v), read_of(f), write_to(c_w), &wanted, &c_report),
            TN_OK)
      << last_error(handle);

  EXPECT_EQ(c_w, w);
  EXPECT_EQ(c_lambda, lambda);
  EXPECT_EQ(c_forces, forces);
  EXPECT_EQ(c_stress, stress);
  expect_same(c_report, report);
  EXPECT_NE(c_report.virial[0], 0.0);
}

/// The call takes the length of a step, lengths that change, and all optional results.
TEST(CCalls, ConstrainsVelocitiesAsTheConstrainer) {
  const Tailed host;
  const Handle handle = host.make_handle();
  Constrainer constrainer = host.make_constrainer();
  const std::int64_t id = 3;
  const double length = std::hypot(0.1, 0.9, 0.5), rate = 0.2;
  ASSERT_EQ(tn_set_lengths(handle.get(), 1, &id, &length, &rate), TN_OK) << last_error(handle);
  constrainer.set_lengths({&id, 1}, {&length, 1}, {&rate, 1});
  std::vector<double> v = host.v, c_v = host.v, lambda(4), c_lambda(4);
  const tn_wanted wanted{sizeof(tn_wanted), 1, c_lambda.data(), {}, {}};
  tn_report c_report = empty_report();

  const ConstraintReport report = constrainer.constrain_velocities(
      {.step = 0.01, .positions = host.r, .velocities = v, .wanted = {.multipliers = lambda}});
  ASSERT_EQ(tn_constrain_velocities(handle.get(), 0.01, read_of(host.r), write_to(c_v), &wanted, &c_report), TN_OK)
      << last_error(handle);

  EXPECT_EQ(c_v, v);
  EXPECT_EQ(c_lambda, lambda);
  expect_same(c_report, report);
  EXPECT_NE(c_report.work, 0.0);
}

TEST(CCalls, MeasuresOnRequestAlone) {
  const Tailed host;
  const Handle handle = host.make_handle();
  for (const int measures : {0, 1}) {
    std::vector<double> r = host.r, v = host.v;
    for (std::size_t k = 0; k < 12; ++k) r[k] += 1e-2 * v[k];
    const tn_wanted wanted{sizeof(tn_wanted), measures, nullptr, {}, {}};
    std::array<tn_report, 3> reports{empty_report(), empty_report(), empty_report()};

    ASSERT_EQ(
        tn_constrain_positions(handle.get(), 1e-2, read_of(host.r), write_to(r), write_to(v), &wanted, reports.data()),
        TN_OK);
    ASSERT_EQ(tn_constrain_velocities(handle.get(), 1e-2, read_of(r), write_to(v), &wanted, &reports[1]), TN_OK);
    ASSERT_EQ(tn_solve(handle.get(), read_of(r), read_of(v), read_of(host.v), {}, &wanted, &reports[2]), TN_OK);

    for (const tn_report& report : reports) {
      EXPECT_EQ(report.worst_row >= 0, measures != 0);
      EXPECT_EQ(report.virial[0] != 0.0, measures != 0);
    }
    EXPECT_EQ(reports[0].largest_turn != 0.0, measures != 0);
  }
}

TEST(CCalls, ProjectsAsTheConstrainer) {
  const Tailed host;
  const Handle handle = host.make_handle();
  Constrainer constrainer = host.make_constrainer();
  std::vector<double> r = host.r, f = host.v;
  for (std::size_t k = 0; k < 12; ++k) r[k] += 0.1 * host.v[k];
  std::vector<double> c_r = r, c_f = f;
  tn_report c_report = empty_report();

  ASSERT_EQ(tn_violation(handle.get(), read_of(r), &c_report), TN_OK);
  expect_same(c_report, constrainer.violation(r));
  EXPECT_GT(c_report.violation, 1e-3);
  ASSERT_EQ(tn_project_positions(handle.get(), write_to(c_r), &c_report), TN_OK) << last_error(handle);
  expect_same(c_report, constrainer.project_positions(r));
  EXPECT_EQ(c_r, r);
  EXPECT_GT(c_report.largest_turn, 1e-3);
  EXPECT_GT(c_report.correction, 1e-3);
  std::vector<double> lambda(constrainer.num_rows()), c_lambda(lambda.size());
  tn_wanted wanted{};
  wanted.size = sizeof wanted;
  wanted.multipliers = c_lambda.data();
  ASSERT_EQ(tn_project_forces(handle.get(), read_of(r), write_to(c_f), &wanted, &c_report), TN_OK)
      << last_error(handle);
  expect_same(c_report, constrainer.project_forces(r, f, 0.0, {.multipliers = lambda}));
  EXPECT_EQ(c_f, f);
  EXPECT_EQ(c_lambda, lambda);
  EXPECT_NE(lambda[0], 0.0);
}

/// Each kind of tn_add has the rows, the violation and the id of the same constraint added in C++.
TEST(CCalls, EveryKindIsThatOfTheConstrainer) {
  struct Row {
    tn_kind kind;
    std::vector<std::int32_t> points;
    std::vector<double> parameters;
    Constraint constraint;
  };
  const std::vector<Row> rows{
      {TN_ROD, {0, 3}, {2.5}, Rods{{}, {{0, 3}}, 2.5}},
      {TN_ANGLE, {0, 1, 3}, {0.25}, Angles{{}, {{0, 1, 3}}, 0.25}},
      {TN_PLANE, {1}, {0.5, 1, 2, 3}, Planes{{}, {1}, Vector3{0.5, 1, 2}, 3.0}},
      {TN_SPHERE, {2}, {1, 2, 3, 4}, Spheres{{}, {2}, Vector3{1, 2, 3}, 4.0}},
      {TN_LINE, {3}, {1, 2, 3, 4, 5, 6}, Lines{{}, {3}, Vector3{1, 2, 3}, Vector3{4, 5, 6}}},
      {TN_CIRCLE, {0}, {1, 2, 3, 4, 5, 6, 7}, Circles{{}, {0}, Vector3{1, 2, 3}, Vector3{4, 5, 6}, 7.0}}};
  for (const Row& row : rows) {
    const Tailed host;
    tn_system* system = nullptr;
    ASSERT_EQ(tn_create(&system, 4, host.masses.data(), read_of(host.r), nullptr), TN_OK);
    const Handle handle(system);
    Constrainer constrainer(host.masses, {row.constraint}, host.r);
    std::int64_t id = -1;
    tn_report report = empty_report();
    std::vector<double> r = host.r, c_r = host.r;

    ASSERT_EQ(tn_add(system, row.kind, 1, row.points.data(), row.parameters.data(), &id), TN_OK) << last_error(handle);
    ASSERT_EQ(tn_violation(system, read_of(host.r), &report), TN_OK) << last_error(handle);
    expect_same(report, constrainer.violation(host.r));
    ASSERT_EQ(tn_project_positions(system, write_to(c_r), nullptr), TN_OK) << last_error(handle);
    ASSERT_TRUE(constrainer.project_positions(r).outcome.ok());

    EXPECT_EQ(c_r, r) << row.kind;
    EXPECT_EQ(id, 0);
    EXPECT_EQ(tn_num_rows(system), constrainer.num_rows()) << row.kind;
  }
}

TEST(CCalls, MembersOfEqualShapeStayTogetherAndOthersDoNot) {
  const Tailed host;
  const Handle handle = host.make_handle();
  const std::array<std::int32_t, 3> points{0, 1, 2};
  const std::array<double, 12> planes{0, 0, 1, 0, 0, 0, 1, 0.1, 0, 1, 0, 0.9};
  std::array<std::int64_t, 3> ids{};
  ASSERT_EQ(tn_add(handle.get(), TN_PLANE, 3, points.data(), planes.data(), ids.data()), TN_OK) << last_error(handle);
  EXPECT_EQ(ids, (std::array<std::int64_t, 3>{4, 5, 6}));
  std::array<char, 32> name{};
  for (const auto& [row, wanted] : {std::pair(std::size_t{5}, "plane1[1]"), std::pair(std::size_t{6}, "plane2[0]")}) {
    ASSERT_EQ(tn_row_name(handle.get(), row, name.data(), name.size()), TN_OK);
    EXPECT_STREQ(name.data(), wanted);
  }
  // Lengths of their own do not split the rods into groups. Rods without given lengths keep those that they have.
  const std::array<std::int32_t, 4> pairs{0, 3, 1, 3};
  const std::array<double, 2> lengths{2, 3};
  ASSERT_EQ(tn_add(handle.get(), TN_ROD, 2, pairs.data(), lengths.data(), nullptr), TN_OK) << last_error(handle);
  ASSERT_EQ(tn_row_name(handle.get(), 8, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "rod3[1]");
  ASSERT_EQ(tn_add(handle.get(), TN_ROD, 1, pairs.data(), nullptr, ids.data()), TN_OK) << last_error(handle);
  ASSERT_EQ(tn_remove(handle.get(), 1, ids.data()), TN_OK);
  // The first group was added before the second one was refused.
  const std::array<double, 8> wrong{0, 0, 1, 0, 0, 0, 0, 0}, none{0, 0, 1, 0, nan, 0, 1, 0};
  for (const auto& each : {wrong, none}) {
    EXPECT_EQ(tn_add(handle.get(), TN_PLANE, 2, points.data(), each.data(), nullptr), TN_EINVAL);
    EXPECT_NE(last_error(handle).find("normal"), std::string::npos) << last_error(handle);
    EXPECT_EQ(tn_num_rows(handle.get()), 9U);
  }
}

TEST(CCalls, CodesAreThoseOfTheOutcome) {
  const std::vector<double> masses(2, 1.0), r{0, 0, 0, 1, 0, 0};
  tn_system* system = nullptr;
  ASSERT_EQ(tn_create(&system, 2, masses.data(), read_of(r), nullptr), TN_OK);
  const Handle handle(system);
  const std::array<std::int32_t, 4> twice{0, 1, 0, 1};
  const std::array<std::int64_t, 2> ids{0, 1};
  const std::array<double, 2> lengths{1, 1}, rates{0, 0.5};
  ASSERT_EQ(tn_add_rods(system, 2, twice.data(), lengths.data(), nullptr, nullptr), TN_OK) << last_error(handle);
  double value = 42.0;
  EXPECT_EQ(tn_log_det(system, read_of(r), &value, {}), TN_SINGULAR);
  EXPECT_EQ(value, 42.0);
  EXPECT_NE(last_error(handle).find("depends on other rows"), std::string::npos) << last_error(handle);

  ASSERT_EQ(tn_set_lengths(system, 2, ids.data(), lengths.data(), rates.data()), TN_OK) << last_error(handle);
  std::vector<double> v(6, 0.0);
  EXPECT_EQ(tn_constrain_velocities(system, 0.0, read_of(r), write_to(v), nullptr, nullptr), TN_CONTRADICTORY);
  EXPECT_EQ(v, std::vector<double>(6, 0.0));
}

/// The host's points have a stride, another order and strangers in between from the start.
TEST(CCalls, CreatesFromPointsOfAnyLayout) {
  const Tailed host;
  const std::array<std::int32_t, 4> index{5, 0, 3, 2};
  std::vector<double> apart(7 * 6, nan);
  for (std::size_t i = 0; i < 4; ++i) std::copy_n(&host.r[3 * i], 3, &apart[7 * static_cast<std::size_t>(index[i])]);
  tn_system* system = nullptr;
  ASSERT_EQ(tn_create(&system, 4, host.masses.data(), {apart.data(), 7 * sizeof(double), index.data()}, nullptr),
            TN_OK);
  const Handle handle(system);
  EXPECT_EQ(tn_num_points(system), 4U);
  EXPECT_EQ(tn_num_rows(system), 0U);
  ASSERT_EQ(tn_add_rods(system, 4, host.pairs.data(), nullptr, nullptr, nullptr), TN_OK) << last_error(handle);
  tn_report report = empty_report();
  ASSERT_EQ(tn_violation(system, read_of(host.r), &report), TN_OK);
  EXPECT_LT(report.violation, 1e-15);
}

TEST(CCalls, RodsHaveTheGivenLengths) {
  const Tailed host;
  tn_system* system = nullptr;
  ASSERT_EQ(tn_create(&system, 4, host.masses.data(), read_of(host.r), nullptr), TN_OK);
  const Handle handle(system);
  const double length = 3.0;
  ASSERT_EQ(tn_add_rods(system, 0, nullptr, nullptr, nullptr, nullptr), TN_OK);
  ASSERT_EQ(tn_add_rods(system, 1, host.pairs.data(), &length, nullptr, nullptr), TN_OK) << last_error(handle);
  tn_report report = empty_report();
  ASSERT_EQ(tn_violation(system, read_of(host.r), &report), TN_OK);
  EXPECT_NEAR(report.violation, 1.0 - std::hypot(1.0, 0.2, 0.1) / length, 1e-15);
}

/// A new point begins where the host says that it is now.
TEST(CCalls, RenumberedPointsAreWhereTheHostSays) {
  const Tailed host;
  const Handle handle = host.make_handle();
  const std::array<std::int64_t, 5> from{0, 1, 2, 3, -1};
  const std::array<double, 5> masses{1.0, 2.0, 0.5, 1.5, 1.0};
  std::vector<double> r = host.r;
  r.insert(r.end(), {0.5, 1.8, 5.3});
  ASSERT_EQ(tn_renumber(handle.get(), 5, from.data(), masses.data(), read_of(r)), TN_OK) << last_error(handle);
  const std::array<std::int32_t, 2> pair{3, 4};
  ASSERT_EQ(tn_add_rods(handle.get(), 1, pair.data(), nullptr, nullptr, nullptr), TN_OK) << last_error(handle);
  tn_report report = empty_report();
  ASSERT_EQ(tn_violation(handle.get(), read_of(r), &report), TN_OK);
  EXPECT_LT(report.violation, 1e-15);
}

/// The cell repeats itself along a alone, from the second cell on, so that a rod that crosses most of it along b is as
/// long as it looks. The old cell is that of one step.
TEST(CCalls, CellsRepeatWhereTheFlagsSay) {
  const std::array<double, 9> wide{10, 0, 0, 0.5, 40, 0, 0, 0, 50}, cell{10, 0, 0, 0.5, 4, 0, 0, 0, 5},
      larger{11, 0, 0, 0.55, 4.4, 0, 0, 0, 5.5};
  const auto cell_of = [](const std::array<double, 9>& c, bool is_wide = false) {
    return PeriodicCell{{Vector3{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}}, {true, is_wide, is_wide}};
  };
  const std::array<int, 3> along_a{1, 0, 0};
  const std::vector<double> masses{1.0, 3.0};
  const std::array<std::int32_t, 2> pair{0, 1};
  std::vector<double> old{9.8, 0.2, 1, 0.4, 3.6, 1};
  Constrainer constrainer(masses, {Rods{{}, {{0, 1}}}}, old, Periodicity{cell_of(wide, true), {}});
  tn_system* system = nullptr;
  ASSERT_EQ(tn_create(&system, 2, masses.data(), read_of(old), nullptr), TN_OK);
  const Handle handle(system);
  ASSERT_EQ(tn_set_box(system, wide.data(), nullptr), TN_OK);
  ASSERT_EQ(tn_add_rods(system, 1, pair.data(), nullptr, nullptr, nullptr), TN_OK) << last_error(handle);
  ASSERT_EQ(tn_set_box(system, larger.data(), along_a.data()), TN_OK);
  constrainer.set_cell(cell_of(larger));
  ASSERT_EQ(tn_set_old_box(system, cell.data()), TN_OK);
  PeriodicCell old_cell = cell_of(cell);

  for (const int step : {0, 1}) {
    std::vector<double> r = old, c_r;
    for (std::size_t k = 0; k < 6; ++k) r[k] = 1.05 * r[k] + (k == 1 ? 0.3 : 0.0);
    c_r = r;
    ASSERT_TRUE(
        constrainer
            .constrain_positions(
                {.step = 0.1, .old_positions = old, .positions = r, .old_cell = step == 0 ? &old_cell : nullptr})
            .outcome.ok());
    ASSERT_EQ(tn_constrain_positions(system, 0.1, read_of(old), write_to(c_r), {}, nullptr, nullptr), TN_OK)
        << last_error(handle);

    EXPECT_EQ(c_r, r);
    EXPECT_NEAR(std::hypot(r[3] + 11 - r[0], r[4] - r[1], r[5] - r[2]), std::hypot(0.6, 3.4), 1e-13);
    old = r;
  }
}

TEST(CCalls, ImagesAreCountedAlongEachEdge) {
  const std::array<double, 9> cell{2, 0, 0, 0.5, 3, 0, 0, 0, 4};
  const std::vector<double> masses(2, 1.0), r{0.1, 0.2, 0.3, 1, 2, 3};
  const std::array<std::int32_t, 2> pair{0, 1};
  const std::array<std::int32_t, 3> image{1, 2, 3};
  const double length = std::hypot(0.9 + 2 + 2 * 0.5, 1.8 + 2 * 3, 2.7 + 3 * 4);
  tn_system* system = nullptr;
  ASSERT_EQ(tn_create(&system, 2, masses.data(), read_of(r), nullptr), TN_OK);
  const Handle handle(system);
  ASSERT_EQ(tn_set_box(system, cell.data(), nullptr), TN_OK);
  ASSERT_EQ(tn_add_rods(system, 1, pair.data(), &length, image.data(), nullptr), TN_OK) << last_error(handle);
  tn_report report = empty_report();
  ASSERT_EQ(tn_violation(system, read_of(r), &report), TN_OK);
  EXPECT_LT(report.violation, 1e-15);
}

TEST(CCalls, ACellComesBeforeConstraints) {
  const Tailed host;
  const Handle handle = host.make_handle();
  const std::array<double, 9> cell{9, 0, 0, 0, 9, 0, 0, 0, 9};
  EXPECT_EQ(tn_set_box(handle.get(), cell.data(), nullptr), TN_EINVAL);
  EXPECT_EQ(last_error(handle), "/cell: the first one comes before the first constraints");
  EXPECT_EQ(tn_set_old_box(handle.get(), cell.data()), TN_EINVAL);
  EXPECT_EQ(last_error(handle), "/cell: there is none; tn_set_box gives one");
}

/// `inexact` leaves out the refinement of accelerations.
TEST(CCalls, InexactSolvesAreNotRefined) {
  const System lattice = scenes::make_lattice(12);
  const auto& rods = std::get<Rods>(lattice.constraints[0]);
  std::vector<int32_t> pairs;
  for (const auto& pair : rods.pairs) pairs.insert(pairs.end(), pair.begin(), pair.end());
  const std::vector<double>&r = lattice.positions, &v = lattice.velocities, f(r.size());
  int refinements[2];
  for (const int32_t inexact : {0, 1}) {
    const tn_options options{sizeof(tn_options), 1, 0.0, inexact};
    tn_system* system = nullptr;
    ASSERT_EQ(tn_create(&system, lattice.masses.size(), lattice.masses.data(), read_of(r), &options), TN_OK);
    ASSERT_EQ(tn_add_rods(system, rods.pairs.size(), pairs.data(), nullptr, nullptr, nullptr), TN_OK);
    tn_report report{};
    report.size = sizeof(report);
    EXPECT_EQ(tn_solve(system, read_of(r), read_of(v), read_of(f), {}, nullptr, &report), TN_OK);
    EXPECT_LE(report.violation, inexact ? 1e-12 : 4e-15);
    refinements[inexact] = report.iterations;
    tn_destroy(system);
  }
  EXPECT_GE(refinements[0], 1);
  EXPECT_EQ(refinements[1], 0);
}

/// The run begins at a time of the host's, and the constraints hold to the tolerance that its options give.
TEST(CCalls, RunsFromAGivenTime) {
  const Tailed host;
  const tn_options options{sizeof(tn_options), 1, 1e-4, 0};
  const Handle handle = host.make_handle(&options);
  Constrainer constrainer = host.make_constrainer();
  std::vector<double> r = host.r, v = host.v, f(12, 0.25);
  ASSERT_EQ(tn_constrain_velocities(handle.get(), 0.0, read_of(r), write_to(v), nullptr, nullptr), TN_OK);
  std::vector<double> own_r = host.r, own_v = v;
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = own_r, .velocities = own_v}).outcome.ok());
  std::vector<double> times;
  tn_loop loop{};
  loop.size = sizeof(loop);
  loop.dt = 0.05;
  loop.time = 7.0;
  loop.steps = 4;
  loop.x = write_to(r);
  loop.v = write_to(v);
  loop.f = write_to(f);
  loop.user = &times;
  loop.observe = [](void* user, const tn_progress* now) {
    static_cast<std::vector<double>*>(user)->push_back(now->time);
    return 1;
  };

  ASSERT_EQ(tn_run(handle.get(), &loop, nullptr), TN_OK) << last_error(handle);

  ASSERT_EQ(times.size(), 4U);
  EXPECT_DOUBLE_EQ(times.front(), 7.05);
  EXPECT_DOUBLE_EQ(times.back(), 7.2);
  ASSERT_TRUE(run(&constrainer,
                  {.step = 0.05, .steps = 4, .positions = own_r, .velocities = own_v, .forces = f, .tolerance = 1e-4})
                  .outcome.ok());
  EXPECT_EQ(r, own_r);
}

TEST(CCalls, SavesOnlyWhereThereIsRoom) {
  const Tailed host;
  const Handle handle = host.make_handle();
  std::size_t needed = 0;
  ASSERT_EQ(tn_save(handle.get(), nullptr, &needed), TN_OK);
  std::vector<std::byte> bytes(needed, std::byte{7});
  std::size_t size = needed - 1;
  EXPECT_EQ(tn_save(handle.get(), bytes.data(), &size), TN_EINVAL);
  EXPECT_EQ(size, needed);
  EXPECT_EQ(bytes, std::vector<std::byte>(needed, std::byte{7}));
  EXPECT_EQ(last_error(handle),
            "there is room for " + std::to_string(needed - 1) + " of " + std::to_string(needed) + " bytes");
}

/// Required arguments that are null are named in the message; optional ones may be null.
TEST(CCalls, NullPointersAreNamed) {
  const Tailed host;
  const Handle handle = host.make_handle();
  tn_system* const system = handle.get();
  const tn_const_points x = read_of(host.r);
  const std::int64_t id = 0;
  const std::int32_t point = 0;
  const double number = 1.0;
  std::size_t size = 0;
  char text = 'x';
  const std::vector<std::pair<std::string, std::function<int()>>> calls{
      {"pairs is a null pointer", [&] { return tn_add_rods(system, 1, nullptr, nullptr, nullptr, nullptr); }},
      {"points is a null pointer", [&] { return tn_add(system, TN_ROD, 1, nullptr, &number, nullptr); }},
      {"parameters is a null pointer", [&] { return tn_add(system, TN_PLANE, 1, &point, nullptr, nullptr); }},
      {"ids is a null pointer", [&] { return tn_set_lengths(system, 1, nullptr, &number, nullptr); }},
      {"lengths is a null pointer", [&] { return tn_set_lengths(system, 1, &id, nullptr, nullptr); }},
      {"points is a null pointer", [&] { return tn_set_masses(system, 1, nullptr, &number); }},
      {"masses is a null pointer", [&] { return tn_set_masses(system, 1, &point, nullptr); }},
      {"from is a null pointer", [&] { return tn_renumber(system, 1, nullptr, &number, x); }},
      {"masses is a null pointer", [&] { return tn_renumber(system, 1, &id, nullptr, x); }},
      {"cell is a null pointer", [&] { return tn_set_box(system, nullptr, nullptr); }},
      {"value is a null pointer", [&] { return tn_log_det(system, x, nullptr, {}); }},
      {"removed is a null pointer", [&] { return tn_removed_dof(system, x, nullptr, nullptr); }},
      {"loop is a null pointer", [&] { return tn_run(system, nullptr, &size); }},
      {"size is a null pointer", [&] { return tn_save(system, nullptr, nullptr); }},
      {"data is a null pointer", [&] { return tn_restore(system, nullptr, 8); }},
      {"there is no room for the name of a row", [&] { return tn_row_name(system, 0, nullptr, 8); }},
      {"there is no room for the name of a row", [&] { return tn_row_name(system, 0, &text, 0); }}};
  for (const auto& [message, call] : calls) {
    EXPECT_EQ(call(), TN_EINVAL) << message;
    EXPECT_EQ(last_error(handle), message);
  }
  EXPECT_EQ(text, 'x');
  EXPECT_EQ(tn_create(nullptr, 4, host.masses.data(), x, nullptr), TN_EINVAL);
  EXPECT_STREQ(tn_create_error(), "out is a null pointer");
  tn_system* none = system;
  EXPECT_EQ(tn_create(&none, 4, host.masses.data(), {nullptr, 0, nullptr}, nullptr), TN_EINVAL);
  EXPECT_EQ(none, nullptr);
  EXPECT_EQ(tn_num_points(nullptr), 0U);
  EXPECT_EQ(tn_num_rows(nullptr), 0U);
  tn_destroy(nullptr);
  EXPECT_EQ(tn_rows(system, 0, nullptr, nullptr), TN_OK);
  EXPECT_EQ(tn_plan(system, nullptr), TN_OK);
  EXPECT_EQ(tn_add(system, static_cast<tn_kind>(7), 1, &point, &number, nullptr), TN_EINVAL);
  EXPECT_EQ(last_error(handle), "there is no kind 7");
}

}  // namespace
}  // namespace tanor::host
