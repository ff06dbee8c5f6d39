/// Parts that ranks bring themselves move as the whole system does on one rank.

#include <cmath>
#include <limits>
#include <numeric>

#include <gtest/gtest.h>
#include <tanor/motion.hpp>

#include "ranks/on_ranks.hpp"
#include "scenes.hpp"

namespace tanor {
namespace {

constexpr std::size_t clusters = 7;

/// Chains of four rods with a spring in each, every second one hanging from a support, in air. Each chain is another.
struct Chains {
  System system;
  Rods rods{"rods", {}, {}, {}};
  Springs springs{"springs", {}, 4.0, 0.05, 0.3};
  Drag air{"air", {}, 0.02, 0.01};
  Support hooks{"hooks", {}, {ScalarFunction::formula("0.01*sin(9*t)^2"), 0.0, 0.0}};

  void add(std::size_t k) {
    const double bend = 0.02 + 0.01 * static_cast<double>(k);
    const auto first = static_cast<Index>(system.num_points());
    for (Index i = 0; i < 5; ++i) {
      const Index point = scenes::add_point(
          {static_cast<double>(k) + 0.1 * i, i % 2 == 1 ? bend : 0.0, 0.01 * i * static_cast<double>(k)}, &system);
      if (i > 0) rods.pairs.push_back({point - 1, point});
      air.points.push_back(point);
    }
    springs.pairs.push_back({first, first + 4});
    if (k % 2 == 0) hooks.points.push_back(first + 2);
  }
  System take() {
    std::erase_if(air.points, [&](Index point) { return std::ranges::count(hooks.points, point) > 0; });
    system.constraints = {rods};
    system.forces = {Gravity{"", {0, 0, -scenes::g}}, springs, air};
    if (!hooks.points.empty()) system.supports = {hooks};
    return system;
  }
};

/// Makes the chains from `first` up to `end`.
System make_chains(std::size_t first, std::size_t end) {
  Chains chains;
  for (std::size_t k = first; k < end; ++k) chains.add(k);
  return chains.take();
}

/// The first chain of each rank, then the number of all.
constexpr std::array<std::size_t, 4> starts{0, 3, 4, clusters};

Ending run_joined(const MotionOptions& options, double t_end) {
  const System whole = make_chains(0, clusters);
  Ending ending;
  for (std::vector<double>* array : {&ending.positions, &ending.velocities, &ending.reactions})
    array->resize(3 * whole.num_points());
  ending.multipliers.resize(num_equations(whole));
  std::vector<MotionReport> reports(3);
  ThreadWorld(3).run([&](Ranks& ranks) {
    const auto rank = static_cast<std::size_t>(ranks.rank());
    const RankSystem own = join_parts(make_chains(starts[rank], starts[rank + 1]), ranks);
    EXPECT_EQ(own.num_owned, own.system.num_points());
    Simulation simulation(own.system, own.part, options, one_thread());
    ASSERT_TRUE(simulation.advance_to(t_end).ok()) << simulation.outcome().what;
    for (std::size_t i = 0; i < own.num_owned; ++i) {
      const auto at = 3 * static_cast<std::size_t>(own.points[i]);
      for (std::size_t c = 0; c < 3; ++c) {
        ending.positions[at + c] = simulation.positions()[3 * i + c];
        ending.velocities[at + c] = simulation.velocities()[3 * i + c];
        ending.reactions[at + c] = simulation.reactions()[3 * i + c];
      }
    }
    for (std::size_t a = 0; a < own.equations.size(); ++a)
      ending.multipliers[own.equations[a]] = simulation.multipliers()[a];
    reports[rank] = simulation.report();
  });
  for (const MotionReport& report : reports) {
    EXPECT_EQ(report.steps, reports[0].steps);
    EXPECT_EQ(report.energy.now, reports[0].energy.now);
  }
  ending.report = reports[0];
  return ending;
}

TEST(JoinedParts, MoveAsTheWholeSystem) {
  const System whole = make_chains(0, clusters);
  std::vector<int> owner;
  for (std::size_t k = 0; k < clusters; ++k) owner.insert(owner.end(), 5, k < starts[1] ? 0 : k < starts[2] ? 1 : 2);
  for (const MotionOptions& options : {options_of(Method::Auto), options_of(Method::Dop853),
                                       options_of(Method::Rattle, 1e-3), options_of(Method::GeneralizedAlpha, 1e-3)}) {
    SCOPED_TRACE(name_of(options.method));
    const Ending one = run_whole(whole, options, 0.1), taken = run_on_ranks(whole, owner, 3, options, 0.1),
                 joined = run_joined(options, 0.1);
    EXPECT_LE(difference(joined.reactions, one.reactions), 1e-11);  // those of supports, too
    for (const Ending& other : {one, taken}) {
      EXPECT_EQ(joined.report.method, other.report.method);
      EXPECT_EQ(joined.report.steps, other.report.steps);
      EXPECT_EQ(joined.report.rejected, other.report.rejected);
      EXPECT_LE(difference(joined.positions, other.positions), 1e-12);
      EXPECT_LE(difference(joined.velocities, other.velocities), 1e-12);
      EXPECT_LE(difference(joined.multipliers, other.multipliers), 1e-11);
      EXPECT_NEAR(joined.report.energy.now, other.report.energy.now, 1e-12 * other.report.energy.scale);
      EXPECT_NEAR(joined.report.energy.work_of_supports, other.report.energy.work_of_supports,
                  1e-12 * other.report.energy.scale);
    }
  }
}

/// One of two ranks, which pretends that the other one has so many of all that is counted.
class LonelyRank final : public Ranks {
 public:
  explicit LonelyRank(double others) : others_(others) {}
  int rank() const override { return 0; }
  int size() const override { return 2; }
  void sum(std::span<double> numbers) override { numbers.back() = others_; }
  void find_largest(std::span<double>) override {}
  void share(int, std::string*) override {}
  void exchange(std::span<const Message>) override {}

 private:
  double others_;
};

TEST(JoinedParts, MorePointsThanNumbersAreRefused) {
  const System own = make_chains(0, 1);
  const double most = std::numeric_limits<Index>::max();
  LonelyRank fits(most - 5.0), exceeds(most - 4.0);
  EXPECT_EQ(join_parts(own, fits).points.back(), 4);
  try {
    (void)join_parts(own, exceeds);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("2147483648 points on all ranks together"), std::string::npos)
        << error.what();
  }
}

/// One rank brings mechanisms of every kind, the other one a body that spins; the steps are the same.
TEST(JoinedParts, MoveInCoordinates) {
  System body = scenes::make_coordinates();
  body.positions.resize(12);
  body.positions = {0, 0, 0, 0.1, 0, 0, 0, 0.1, 0, 0, 0, 0.1};
  body.masses = {0.1, 0.2, 0.3, 0.4};
  body.velocities.clear();
  body.supports.clear();
  body.forces = {scenes::gravity};
  body.coordinates = {RigidBody{"body", {0, 1, 2, 3}}};
  scenes::set_rigid_motion({0, 0, 0}, {1, 2, 3}, &body);
  MotionOptions options = options_of(Method::Auto);
  options.start = StartMode::Project;
  std::array<std::size_t, 2> steps{};
  ThreadWorld(2).run([&](Ranks& ranks) {
    const System own = ranks.rank() == 0 ? scenes::make_coordinates() : body;
    const Ending alone = run_whole(own, options, 0.2);
    const RankSystem part = join_parts(own, ranks);
    Simulation simulation(part.system, part.part, options, one_thread());
    ASSERT_TRUE(simulation.advance_to(0.2).ok()) << simulation.outcome().what;
    EXPECT_EQ(simulation.plan().form, Form::Tangent);
    EXPECT_LE(difference({simulation.positions().begin(), simulation.positions().end()}, alone.positions), 1e-8);
    steps[static_cast<std::size_t>(ranks.rank())] = simulation.report().steps;
  });
  EXPECT_EQ(steps[0], steps[1]);
}

TEST(JoinedParts, CoordinatesOfOneRankAreRefusedOnAll) {
  ThreadWorld(2).run([](Ranks& ranks) {
    const System own = ranks.rank() == 0 ? make_chains(0, 1) : scenes::make_coordinates();
    EXPECT_THROW((void)join_parts(own, ranks), InputError);
  });
}

}  // namespace
}  // namespace tanor
