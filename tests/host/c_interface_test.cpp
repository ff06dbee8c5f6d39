/// The interface for C is compared with the Constrainer that it stands for. tests/package has a program in C.

#include <gtest/gtest.h>
#include <tanor.h>
#include <tanor/velocity_verlet.hpp>

#include <array>
#include <cmath>
#include <string>
#include <thread>
#include <vector>

#include <tanor/build_info.hpp>

#include "host/c_handle.hpp"
#include "host/velocity_verlet.hpp"

namespace tanor::host {
namespace {

TEST(CInterface, VersionSaysWhatTheLibraryWasBuiltOf) {
  EXPECT_EQ(tn_version(), describe(build_info()));
  EXPECT_EQ(std::string(tn_version()).find("SuiteSparseQR") != std::string::npos, build_info().has_suitesparse_qr);
}

TEST(CInterface, HasTheBitsOfTheConstrainer) {
  const double h = 1e-2;
  const Tailed host;
  const Handle handle = host.make_handle();
  Constrainer constrainer = host.make_constrainer();
  std::vector<double> r = host.r, v = host.v, lambda(4), forces(12), stress(36);
  for (std::size_t k = 0; k < 12; ++k) r[k] += h * v[k];
  std::vector<double> c_r = r, c_v = v, c_lambda(4), c_forces(12), c_stress(36);
  const tn_wanted wanted{
      sizeof(tn_wanted), 1, c_lambda.data(), {c_forces.data(), 0, nullptr}, {c_stress.data(), 0, nullptr}};
  tn_report c_report{};
  c_report.size = sizeof(c_report);

  const ConstraintReport report =
      constrainer.constrain_positions({.step = h,
                                       .old_positions = host.r,
                                       .positions = r,
                                       .velocities = v,
                                       .wanted = {.multipliers = lambda, .forces = forces, .stress = stress}});
  ASSERT_TRUE(report.outcome.ok());
  ASSERT_EQ(tn_constrain_positions(handle.get(), h, {host.r.data(), 0, nullptr}, {c_r.data(), 0, nullptr},
                                   {c_v.data(), 0, nullptr}, &wanted, &c_report),
            TN_OK)
      << tn_last_error(handle.get());

  EXPECT_EQ(c_r, r);
  EXPECT_EQ(c_v, v);
  EXPECT_EQ(c_lambda, lambda);
  EXPECT_EQ(c_forces, forces);
  EXPECT_EQ(c_stress, stress);
  EXPECT_EQ(c_report.iterations, report.iterations);
  EXPECT_EQ(c_report.violation, report.violation);
  EXPECT_EQ(c_report.correction, report.correction);
  EXPECT_EQ(c_report.largest_turn, report.largest_turn);
  EXPECT_EQ(static_cast<std::size_t>(c_report.worst_row), report.worst_row);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_EQ(c_report.virial[k], report.virial[k]);

  std::vector<double> f = host.v, c_f = f, gradient(12), c_gradient(12);
  ASSERT_TRUE(constrainer.project_forces(host.r, f).outcome.ok());
  ASSERT_EQ(tn_project_forces(handle.get(), {host.r.data(), 0, nullptr}, {c_f.data(), 0, nullptr}, nullptr, nullptr),
            TN_OK);
  EXPECT_EQ(c_f, f);
  double value = 0.0;
  ASSERT_EQ(tn_log_det(handle.get(), {host.r.data(), 0, nullptr}, &value, {c_gradient.data(), 0, nullptr}), TN_OK);
  EXPECT_EQ(value, constrainer.log_det(host.r, gradient).value);
  EXPECT_EQ(c_gradient, gradient);
  double removed = 0.0;
  ASSERT_EQ(tn_removed_dof(handle.get(), {host.r.data(), 0, nullptr}, nullptr, &removed), TN_OK);
  EXPECT_EQ(removed, 4.0);
  const std::array<std::uint8_t, 4> tail{0, 0, 0, 1};
  ASSERT_EQ(tn_removed_dof(handle.get(), {host.r.data(), 0, nullptr}, tail.data(), &removed), TN_OK);
  EXPECT_EQ(removed, 0.5);
}

/// The structs of this caller are shorter, as those of an older header.
TEST(CInterface, ReadsAndWritesNoFurtherThanTheSize) {
  const Tailed host;
  const Handle handle = host.make_handle();
  tn_report report{};
  report.size = offsetof(tn_report, correction);
  report.correction = 42.0;
  std::array<double, 2> behind{7.0, 7.0};
  std::vector<double> v = host.v;
  tn_wanted wanted{};
  wanted.size = offsetof(tn_wanted, multipliers);
  wanted.multipliers = behind.data();

  ASSERT_EQ(tn_constrain_velocities(handle.get(), 1e-2, {host.r.data(), 0, nullptr}, {v.data(), 0, nullptr}, &wanted,
                                    &report),
            TN_OK);

  EXPECT_EQ(report.iterations, 1);
  EXPECT_EQ(report.correction, 42.0);
  EXPECT_EQ(behind[0], 7.0);
  wanted.size = 0;
  EXPECT_EQ(tn_constrain_velocities(handle.get(), 1e-2, {host.r.data(), 0, nullptr}, {v.data(), 0, nullptr}, &wanted,
                                    nullptr),
            TN_EINVAL);
  EXPECT_STREQ(tn_last_error(handle.get()), "size = 0 of a struct is not sizeof it");
}

/// The last caller has an older header, which knows no tolerance.
TEST(CInterface, HasTheToleranceOfTheConstrainer) {
  const Tailed host;
  const double h = 0.2;
  for (const tn_options options :
       {tn_options{sizeof(tn_options), 1, 0.0, 0}, tn_options{sizeof(tn_options), 1, 1e-4, 0},
        tn_options{offsetof(tn_options, tolerance), 1, 1e-4, 0}}) {
    const double tolerance = options.size == sizeof(tn_options) ? options.tolerance : 0.0;
    const Handle handle = host.make_handle(&options);
    Constrainer constrainer = host.make_constrainer();
    std::vector<double> r = host.r, there;
    for (std::size_t k = 0; k < r.size(); ++k) r[k] += h * host.v[k];
    there = r;
    tn_report report{};
    report.size = sizeof(report);

    ASSERT_EQ(tn_constrain_positions(handle.get(), h, {host.r.data(), 0, nullptr}, {r.data(), 0, nullptr}, {}, nullptr,
                                     &report),
              TN_OK);
    const ConstraintReport wanted = constrainer.constrain_positions(
        {.step = h, .old_positions = host.r, .positions = there, .tolerance = tolerance});

    EXPECT_EQ(r, there);
    EXPECT_EQ(report.iterations, wanted.iterations);
    EXPECT_EQ(report.violation > 1e-12, tolerance > 0.0) << report.violation;
  }
}

TEST(CInterface, ErrorsHaveACodeAndAMessage) {
  const Tailed host;
  tn_system* system = nullptr;
  EXPECT_EQ(tn_create(&system, 4, nullptr, {host.r.data(), 0, nullptr}, nullptr), TN_EINVAL);
  EXPECT_EQ(system, nullptr);
  EXPECT_STREQ(tn_create_error(), "masses or positions are a null pointer");
  const Handle handle = host.make_handle();
  const std::array<std::int32_t, 2> itself{1, 1};
  EXPECT_EQ(tn_add_rods(handle.get(), 1, itself.data(), nullptr, nullptr, nullptr), TN_EINVAL);
  EXPECT_NE(std::string(tn_last_error(handle.get())).find("two different points"), std::string::npos)
      << tn_last_error(handle.get());
  EXPECT_EQ(tn_num_rows(handle.get()), 4U);
  std::vector<double> r = host.r;
  r[3] += 50.0;
  EXPECT_EQ(tn_constrain_positions(handle.get(), 0.1, {host.r.data(), 0, nullptr}, {r.data(), 0, nullptr},
                                   {nullptr, 0, nullptr}, nullptr, nullptr),
            TN_NOT_CONVERGED);
  EXPECT_NE(std::string(tn_last_error(handle.get())).find("rod0["), std::string::npos) << tn_last_error(handle.get());
  r[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(tn_constrain_positions(handle.get(), 0.1, {host.r.data(), 0, nullptr}, {r.data(), 0, nullptr},
                                   {nullptr, 0, nullptr}, nullptr, nullptr),
            TN_NOT_FINITE);
  EXPECT_EQ(
      tn_constrain_velocities(nullptr, 0.1, {host.r.data(), 0, nullptr}, {r.data(), 0, nullptr}, nullptr, nullptr),
      TN_EINVAL);
  EXPECT_STREQ(tn_last_error(nullptr), "the system is a null pointer");
}

/// Rods that are added later stand behind those that were there.
TEST(CInterface, RodsMayBeAddedAfterAStep) {
  const Tailed host;
  const Handle handle = host.make_handle();
  std::vector<double> v = host.v;
  ASSERT_EQ(
      tn_constrain_velocities(handle.get(), 0.0, {host.r.data(), 0, nullptr}, {v.data(), 0, nullptr}, nullptr, nullptr),
      TN_OK);
  const std::array<std::int32_t, 2> one_more{0, 3};
  std::int64_t id = -1;

  ASSERT_EQ(tn_add_rods(handle.get(), 1, one_more.data(), nullptr, nullptr, &id), TN_OK) << tn_last_error(handle.get());
  ASSERT_EQ(
      tn_constrain_velocities(handle.get(), 0.0, {host.r.data(), 0, nullptr}, {v.data(), 0, nullptr}, nullptr, nullptr),
      TN_OK);

  std::size_t row = 0, count = 0;
  ASSERT_EQ(tn_rows(handle.get(), id, &row, &count), TN_OK);
  EXPECT_EQ(row, 4U);
  EXPECT_EQ(count, 1U);
  EXPECT_EQ(tn_num_rows(handle.get()), 5U);
  double rate = 0.0;
  for (std::size_t d = 0; d < 3; ++d) rate += (host.r[9 + d] - host.r[d]) * (v[9 + d] - v[d]);
  EXPECT_NEAR(rate, 0.0, 1e-14);
  std::array<char, 8> name{};
  ASSERT_EQ(tn_row_name(handle.get(), 4, name.data(), name.size()), TN_OK);
  EXPECT_STREQ(name.data(), "rod1[0]");
  ASSERT_EQ(tn_row_name(handle.get(), 4, name.data(), 4), TN_OK);
  EXPECT_STREQ(name.data(), "rod");
}

/// Every kind and every edit gives the result of the same call in C++.
TEST(CInterface, EditsAreThoseOfTheConstrainer) {
  const Tailed host;
  const Handle handle = host.make_handle();
  tn_system* const system = handle.get();
  Constrainer constrainer = host.make_constrainer();
  ASSERT_EQ(tn_plan(system, nullptr), TN_OK);  // what follows are edits there, too
  const tn_const_points x{host.r.data(), 0, nullptr};
  const double* const r = host.r.data();

  std::array<std::int64_t, 2> ids{};
  const std::array<std::int32_t, 3> corner{0, 1, 3};
  ASSERT_EQ(tn_add(system, TN_ANGLE, 1, corner.data(), nullptr, ids.data()), TN_OK) << tn_last_error(system);
  EXPECT_EQ(ids[0], constrainer.add(Angles{{}, {{0, 1, 3}}, {}}));
  const std::array<std::int32_t, 2> held{3, 0};
  const std::array<double, 8> planes{0, 0, 1, r[11], 0, 2, 0, 2 * r[1]};
  ASSERT_EQ(tn_add(system, TN_PLANE, 2, held.data(), planes.data(), ids.data()), TN_OK) << tn_last_error(system);
  (void)constrainer.add(Planes{{}, {3}, Vector3{0, 0, 1}, r[11]});
  EXPECT_EQ(ids[1], constrainer.add(Planes{{}, {0}, Vector3{0, 2, 0}, 2 * r[1]}));
  std::size_t first = 0, count = 0;
  ASSERT_EQ(tn_rows(system, ids[1], &first, &count), TN_OK);
  EXPECT_EQ(first, 6U);
  EXPECT_EQ(count, 1U);
  const std::int64_t tail = 3;
  ASSERT_EQ(tn_remove(system, 1, &tail), TN_OK);
  constrainer.remove({&tail, 1});
  const double length = std::hypot(r[3], r[4], r[5]) * (1.0 + 1e-10), rate = 0.01, mass = 2.5;
  const std::int64_t rod = 0;
  const std::int32_t point = 2;
  ASSERT_EQ(tn_set_lengths(system, 1, &rod, &length, &rate), TN_OK);
  constrainer.set_lengths({&rod, 1}, {&length, 1}, {&rate, 1});
  ASSERT_EQ(tn_set_masses(system, 1, &point, &mass), TN_OK);
  constrainer.set_masses({&point, 1}, {&mass, 1});
  std::size_t islands = 0;
  ASSERT_EQ(tn_plan(system, &islands), TN_OK) << tn_last_error(system);
  EXPECT_EQ(islands, constrainer.update_plan());

  std::vector<double> v = host.v, c_v = host.v;
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = host.r, .velocities = v}).outcome.ok());
  ASSERT_EQ(tn_constrain_velocities(system, 0.0, x, {c_v.data(), 0, nullptr}, nullptr, nullptr), TN_OK);
  EXPECT_EQ(c_v, v);

  std::size_t size = 0;
  ASSERT_EQ(tn_save(system, nullptr, &size), TN_OK);
  std::vector<std::byte> bytes(size);
  ASSERT_EQ(tn_save(system, bytes.data(), &size), TN_OK);
  EXPECT_EQ(bytes, constrainer.save());
  ASSERT_EQ(tn_restore(system, bytes.data(), bytes.size()), TN_OK) << tn_last_error(system);
  EXPECT_EQ(tn_restore(system, bytes.data(), bytes.size() - 1), TN_EINVAL);

  const std::array<std::int64_t, 5> from{3, 2, 1, 0, -1};
  const std::array<double, 5> masses{1.5, 2.5, 2.0, 1.0, 7.0};
  ASSERT_EQ(tn_renumber(system, 5, from.data(), masses.data(), {nullptr, 0, nullptr}), TN_OK) << tn_last_error(system);
  EXPECT_EQ(tn_num_points(system), 5U);
}

/// An observer ends the run where it ends that of the C++ interface.
TEST(CInterface, RunsUntilTheObserverEndsIt) {
  struct User {
    std::vector<double>* forces;
    double time = 0.0;
    std::vector<size_t> steps{};
    double turn = 0.0, virial = 0.0;
  };
  const Tailed host;
  const Handle handle = host.make_handle();
  ASSERT_EQ(tn_expect_edits(handle.get()), TN_OK);
  std::vector<double> r = host.r, v = host.v, f(12, 0.25);
  ASSERT_EQ(
      tn_constrain_velocities(handle.get(), 0.0, {r.data(), 0, nullptr}, {v.data(), 0, nullptr}, nullptr, nullptr),
      TN_OK);
  User user{&f};
  tn_loop loop{};
  loop.size = sizeof(loop);
  loop.measures = 1;
  loop.dt = 1e-2;
  loop.steps = 100;
  loop.x = {r.data(), 0, nullptr};
  loop.v = {v.data(), 0, nullptr};
  loop.f = {f.data(), 0, nullptr};
  loop.user = &user;
  loop.set_forces = [](void* own, double time) {
    User& self = *static_cast<User*>(own);
    self.time = time;
    self.forces->at(4) = std::sin(time);
  };
  loop.observe = [](void* own, const tn_progress* now) {
    User& self = *static_cast<User*>(own);
    self.steps.push_back(now->steps);
    self.turn = now->positions->largest_turn;
    self.virial = now->velocities->virial[0];
    return now->steps < 5 ? 1 : 0;
  };
  std::size_t steps = 0;

  ASSERT_EQ(tn_run(handle.get(), &loop, &steps), TN_OK) << tn_last_error(handle.get());

  EXPECT_EQ(steps, 5U);
  EXPECT_EQ(user.steps, (std::vector<size_t>{1, 2, 3, 4, 5}));
  EXPECT_DOUBLE_EQ(user.time, 5e-2);
  EXPECT_GT(user.turn, 0.0);
  Constrainer constrainer = host.make_constrainer();
  std::vector<double> own_r = host.r, own_v = host.v, own_f(12, 0.25);
  ASSERT_TRUE(constrainer.constrain_velocities({.positions = own_r, .velocities = own_v}).outcome.ok());
  double virial = 0.0;
  const VelocityVerletReport report = run(&constrainer, {.step = 1e-2,
                                                         .steps = 5,
                                                         .positions = own_r,
                                                         .velocities = own_v,
                                                         .forces = own_f,
                                                         .set_forces = [&](double time) { own_f[4] = std::sin(time); },
                                                         .observe =
                                                             [&](const VelocityVerletProgress& now) {
                                                               virial = now.velocities.virial[0];
                                                               return true;
                                                             },
                                                         .measures = true});
  ASSERT_TRUE(report.outcome.ok());
  EXPECT_EQ(r, own_r);
  EXPECT_EQ(v, own_v);
  EXPECT_EQ(user.virial, virial);
  EXPECT_EQ(tn_run(handle.get(), nullptr, nullptr), TN_EINVAL);
  loop.dt = 0.0;
  EXPECT_EQ(tn_run(handle.get(), &loop, &steps), TN_EINVAL);
  EXPECT_EQ(r, own_r);
}

TEST(CInterface, AddsAllConstraintsOrNone) {
  const Tailed host;
  const Handle handle = host.make_handle();
  const std::array<std::int32_t, 2> points{0, 1};
  const std::array<double, 8> spheres{0, 0, 5, 5, 0, 0, 7, -1};
  EXPECT_EQ(tn_add(handle.get(), TN_SPHERE, 2, points.data(), spheres.data(), nullptr), TN_EINVAL);
  EXPECT_NE(std::string(tn_last_error(handle.get())).find("radius"), std::string::npos) << tn_last_error(handle.get());
  EXPECT_EQ(tn_num_rows(handle.get()), 4U);
  EXPECT_EQ(tn_add(handle.get(), static_cast<tn_kind>(7), 1, points.data(), nullptr, nullptr), TN_EINVAL);
  EXPECT_EQ(tn_remove(handle.get(), 1, nullptr), TN_EINVAL);
  EXPECT_STREQ(tn_last_error(handle.get()), "ids is a null pointer");
}

/// The first rod crosses the face x = 0. Given images lead to the same result as the nearest ones.
TEST(CInterface, RodsMayCrossTheFacesOfACell) {
  const std::array<double, 9> cell{3, 0, 0, 0.5, 4, 0, 0, 0, 5}, larger{3.03, 0, 0, 0.505, 4.04, 0, 0, 0, 5.05};
  const std::vector<double> masses(3, 1.0), old{2.6, 1, 1, 0.4, 1.2, 1, 1.2, 1.4, 1};
  const std::array<std::int32_t, 4> pairs{0, 1, 1, 2};
  const std::array<std::int32_t, 6> images{1, 0, 0, 0, 0, 0};
  for (const std::int32_t* const own : {static_cast<const std::int32_t*>(nullptr), images.data()}) {
    tn_system* system = nullptr;
    ASSERT_EQ(tn_create(&system, 3, masses.data(), {old.data(), 0, nullptr}, nullptr), TN_OK);
    const Handle handle(system);
    EXPECT_EQ(tn_set_old_box(system, cell.data()), TN_EINVAL);
    ASSERT_EQ(tn_set_box(system, cell.data(), nullptr), TN_OK) << tn_last_error(system);
    ASSERT_EQ(tn_add_rods(system, 2, pairs.data(), nullptr, own, nullptr), TN_OK) << tn_last_error(system);
    std::vector<double> r = old;
    for (double& x : r) x *= 1.01;
    ASSERT_EQ(tn_set_box(system, larger.data(), nullptr), TN_OK);
    ASSERT_EQ(tn_set_old_box(system, cell.data()), TN_OK);

    ASSERT_EQ(tn_constrain_positions(system, 0.1, {old.data(), 0, nullptr}, {r.data(), 0, nullptr},
                                     {nullptr, 0, nullptr}, nullptr, nullptr),
              TN_OK)
        << tn_last_error(system);

    EXPECT_NEAR(std::hypot(r[3] + 3.03 - r[0], r[4] - r[1], r[5] - r[2]), std::hypot(0.8, 0.2), 1e-13);
    EXPECT_NEAR(std::hypot(r[6] - r[3], r[7] - r[4], r[8] - r[5]), std::hypot(0.8, 0.2), 1e-13);
  }
}

/// Two threads run steps and failing calls of their own handles at once. Each gets its own messages and the same bits.
TEST(CInterface, HandlesAreIndependentInTwoThreads) {
  std::array<std::vector<double>, 2> ends;
  const auto run = [&](std::size_t own) {
    const std::int32_t beyond = 100 + static_cast<std::int32_t>(own);
    const std::array<std::int32_t, 2> wrong{0, beyond};
    const std::string expected = std::to_string(beyond);
    const Tailed host;
    const Handle handle = host.make_handle();
    std::vector<double> old = host.r, r = host.r, v = host.v;
    for (int k = 0; k < 50; ++k) {
      tn_system* none = nullptr;
      const double mass = -1.0 - static_cast<double>(own);
      ASSERT_EQ(tn_create(&none, 1, &mass, {r.data(), 0, nullptr}, nullptr), TN_EINVAL);
      ASSERT_NE(std::string(tn_create_error()).find(own == 0 ? "-1" : "-2"), std::string::npos) << tn_create_error();
      ASSERT_EQ(tn_add_rods(handle.get(), 1, wrong.data(), nullptr, nullptr, nullptr), TN_EINVAL);
      ASSERT_NE(std::string(tn_last_error(handle.get())).find(expected), std::string::npos);
      old = r;
      for (std::size_t d = 0; d < r.size(); ++d) r[d] += 1e-3 * v[d];
      ASSERT_EQ(tn_constrain_positions(handle.get(), 1e-3, {old.data(), 0, nullptr}, {r.data(), 0, nullptr},
                                       {v.data(), 0, nullptr}, nullptr, nullptr),
                TN_OK)
          << tn_last_error(handle.get());
      ASSERT_EQ(
          tn_constrain_velocities(handle.get(), 1e-3, {r.data(), 0, nullptr}, {v.data(), 0, nullptr}, nullptr, nullptr),
          TN_OK)
          << tn_last_error(handle.get());
    }
    ends[own] = r;
  };
  std::thread first(run, 0), second(run, 1);
  first.join();
  second.join();
  EXPECT_EQ(ends[0], ends[1]);
  EXPECT_NE(ends[0], Tailed().r);
}

}  // namespace
}  // namespace tanor::host
