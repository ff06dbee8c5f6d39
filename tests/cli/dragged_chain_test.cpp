#include <cmath>

#include "cli/program.hpp"

/// \file The scenes of tests/data/friction/dragged, which are random chains on rough floors.
namespace tanor::cli {
namespace {

using nlohmann::json;

json run_dragged(const Folder& folder, const std::string& name, const Words& more = {}) {
  const std::filesystem::path scene =
      std::filesystem::path(TANOR_TEST_DATA) / "friction" / "dragged" / (name + ".json");
  Words words{"run", scene.string(), "--out", "out"};
  words.insert(words.end(), more.begin(), more.end());
  const Ended ended = run_program(folder, words);
  EXPECT_EQ(ended.code, 0) << ended.err;
  return read_json(folder / "out" / "summary.json");
}

/// In these chains beads stick beside others on nearly one line, an event lies between two adjacent instants, beads of
/// rows on a line reach their limits one by one, to a rounding, until all give way, and the constraints do not let a
/// bead be put to rest where the support turns round.
TEST(DraggedChains, ArriveWithTheirEnergyBalanced) {
  for (const char* name : {"event_between_instants", "slow_projection", "stops_without_end", "row_of_37", "row_of_45",
                           "support_turns_round"}) {
    SCOPED_TRACE(name);
    const Folder folder;

    const json summary = run_dragged(folder, name);

    EXPECT_LE(std::abs(summary.at("energy").at("drift_relative").get<double>()), 1e-8);
    EXPECT_LT(summary.at("energy").at("work_of_friction").get<double>(), 0.0);
  }
}

/// The motion v' = mu g sgn(u(t) - v) from rest at t = 0, with switches at u = v that are found by bisection. At each
/// of them mu g < |u'|.
struct Block {
  double x = 0.0, v = 0.0;

  Block(double friction, double speed, double omega, double t_end) {
    const auto belt = [&](double t) { return speed * std::sin(omega * t); };
    const double look = 1e-3 / omega;
    double sense = 1.0;
    for (double t = 0.0; t < t_end;) {
      const auto ahead = [&](double s) { return sense * (belt(s) - (v + sense * friction * (s - t))); };
      double low = t + look, high = low;
      while (high < t_end && ahead(high) > 0.0) high += look;
      for (int k = 0; k < 100; ++k) {
        const double middle = 0.5 * (low + high);
        (ahead(middle) > 0.0 ? low : high) = middle;
      }
      const double h = std::min(high, t_end) - t;
      x += h * (v + 0.5 * sense * friction * h);
      v += sense * friction * h;
      t += h;
      sense = -sense;
    }
  }
};

/// A floor that moves to and fro as a whole carries a chain as one block. Friction is the same at all beads, whatever
/// their masses, and rods carry nothing.
TEST(DraggedChains, AreCarriedAsABlockByAFloorThatMovesToAndFro) {
  for (const char* name : {"belt_of_15", "belt_of_13"}) {
    SCOPED_TRACE(name);
    const Folder folder;
    const json scene =
        read_json(std::filesystem::path(TANOR_TEST_DATA) / "friction" / "dragged" / (std::string(name) + ".json"));
    const json& friction = scene.at("friction").at(0);
    double c = 0.0, s = 0.0, speed = 0.0, omega = 0.0;
    ASSERT_EQ(std::sscanf(friction.at("velocity").at("formula").at(0).get<std::string>().c_str(),
                          "(%lf)*(%lf*sin(%lf*t))", &c, &speed, &omega),
              3);
    ASSERT_EQ(std::sscanf(friction.at("velocity").at("formula").at(1).get<std::string>().c_str(), "(%lf)", &s), 1);
    const double size = std::hypot(c, s);  // 1 but for its digits
    const Block block(friction.at("coefficient").get<double>() * 9.81, size * speed, omega,
                      scene.at("motion").at("t_end").get<double>());

    const json summary = run_dragged(folder, name, {"--rtol", "1e-10"});

    EXPECT_LE(std::abs(summary.at("energy").at("drift_relative").get<double>()), 1e-10);
    const json &start = scene.at("points").at("positions"), &end = summary.at("final").at("positions");
    for (std::size_t i = 0; i < start.size(); ++i) {
      EXPECT_NEAR(end[i][0].get<double>() - start[i][0].get<double>(), c / size * block.x, 1e-8) << i;
      EXPECT_NEAR(end[i][1].get<double>() - start[i][1].get<double>(), s / size * block.x, 1e-8) << i;
      EXPECT_NEAR(summary.at("final").at("velocities")[i][0].get<double>(), c / size * block.v, 1e-8) << i;
    }
  }
}

/// The smallest of the event functions has kinks in steps that are longer than beads take to stop.
TEST(DraggedChains, Rk4FindsEventsBeyondKinks) {
  const Folder folder;
  run_dragged(folder, "kinked_events");
}

/// Steps of a fixed length pass over how contacts stop and leave, so that in a chain that whips about chance decides
/// which lengths arrive. If one fails, the error names the method to take.
TEST(DraggedChains, FixedStepsArriveOrNameTheMethodToTake) {
  const Folder folder;
  const std::filesystem::path scene =
      std::filesystem::path(TANOR_TEST_DATA) / "friction" / "dragged" / "cut_steps.json";

  const Ended ended = run_program(folder, {"run", scene.string(), "--t-end", "0.17", "--out", "out"});  // 72 events
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_GE(read_json(folder / "out" / "summary.json").at("contact_changes").get<int>(), 50);
  EXPECT_EQ(run_program(folder, {"run", scene.string(), "--step", "0.0016", "--out", "out"}).code, 0);

  const Ended stopped = run_program(folder, {"run", scene.string(), "--step", "0.0033", "--out", "out"});
  EXPECT_EQ(stopped.code, 3) << stopped.err;
  EXPECT_TRUE(contains(stopped.err, "take method dop853")) << stopped.err;
}

}  // namespace
}  // namespace tanor::cli
