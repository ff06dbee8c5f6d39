#include <cmath>

#include <gtest/gtest.h>

#include "base/checksum.hpp"
#include "report/checkpoint.hpp"
#include "report/json_text.hpp"
#include "report/npy.hpp"
#include "report/output_file.hpp"
#include "report/reading.hpp"
#include "report/shared_parts.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::report {
using namespace detail;
namespace {

using nlohmann::json;

Simulation make_simulation(std::size_t num_points = 4) {
  return Simulation(scenes::make_chain(num_points - 1), {.method = Method::Rk4, .step = 0.01});
}

/// Writes frames of a simulation at t = 0, 0.1, …
void write_frames(int count, Simulation* simulation, Trajectory* trajectory) {
  for (int k = 0; k < count; ++k) {
    if (simulation->time() < 0.1 * k) {
      ASSERT_TRUE(simulation->advance_to(0.1 * k).ok());
    }
    trajectory->write_frame(*simulation);
  }
}

// The trajectory is never closed here, as in a run that is killed.
TEST(TrajectoryTest, EveryFrameIsReadableAtOnce) {
  const Folder folder;
  Simulation simulation = make_simulation();
  Trajectory trajectory(folder.path(), simulation.system(), {});

  write_frames(3, &simulation, &trajectory);

  EXPECT_EQ(list_names(folder.path()), (std::vector<std::string>{"trajectory", "trajectory.pvd", "trajectory.xyz"}));
  EXPECT_EQ(list_names(folder / "trajectory"),
            (std::vector<std::string>{"frame_000000.vtp", "frame_000001.vtp", "frame_000002.vtp"}));
  EXPECT_EQ(read_xyz(folder / "trajectory.xyz").size(), 3u);
  EXPECT_EQ(read_text(folder / "trajectory.pvd"), R"(<?xml version="1.0"?>
<VTKFile type="Collection" version="0.1">
<Collection>
<DataSet timestep="0" group="" part="0" file="trajectory/frame_000000.vtp"/>
<DataSet timestep="0.1" group="" part="0" file="trajectory/frame_000001.vtp"/>
<DataSet timestep="0.2" group="" part="0" file="trajectory/frame_000002.vtp"/>
</Collection>
</VTKFile>
)");
}

TEST(TrajectoryTest, ANewRunForgetsTheFramesOfAnEarlierOne) {
  const Folder folder;
  Simulation earlier = make_simulation();
  Trajectory trajectory(folder.path(), earlier.system(), {});
  write_frames(3, &earlier, &trajectory);

  Simulation simulation = make_simulation();
  for (const std::filesystem::path& file : list_trajectory(folder.path())) remove_file(file);
  Trajectory again(folder.path(), simulation.system(), {});
  write_frames(1, &simulation, &again);

  EXPECT_EQ(list_names(folder / "trajectory"), (std::vector<std::string>{"frame_000000.vtp"}));
  EXPECT_EQ(read_xyz(folder / "trajectory.xyz").size(), 1u);
}

TEST(TrajectoryTest, GoesOnBehindItsMark) {
  const Folder folder;
  Simulation simulation = make_simulation();
  TrajectoryMark mark;
  {
    Trajectory trajectory(folder.path(), simulation.system(), {});
    write_frames(2, &simulation, &trajectory);
    mark = trajectory.mark();
    write_frames(3, &simulation, &trajectory);  // to be forgotten
  }

  Trajectory trajectory(folder.path(), simulation.system(), {}, mark);
  ASSERT_TRUE(simulation.advance_to(0.25).ok());
  trajectory.write_frame(simulation);

  const std::vector<XyzFrame> frames = read_xyz(folder / "trajectory.xyz");
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[1].time, 0.1);
  EXPECT_EQ(frames[2].time, 0.25);
  EXPECT_EQ(count_lines(folder / "trajectory.pvd"), 3u + 3u + 2u);
}

TEST(TrajectoryTest, FilesThatAreNotThoseOfTheMarkStayUntouched) {
  const Folder folder;
  Simulation simulation = make_simulation();
  {
    Trajectory trajectory(folder.path(), simulation.system(), {});
    write_frames(1, &simulation, &trajectory);
  }
  const std::string text = read_text(folder / "trajectory.xyz"), list = read_text(folder / "trajectory.pvd");

  for (const TrajectoryMark& mark : {TrajectoryMark{1, {{"trajectory.pvd", 1}, {"trajectory.xyz", text.size() + 1}}},
                                     TrajectoryMark{2, {{"trajectory.pvd", list.size() + 1}, {"trajectory.xyz", 10}}},
                                     TrajectoryMark{1, {{"trajectory.xyz", 10}}}}) {
    EXPECT_THROW(Trajectory(folder.path(), simulation.system(), {}, mark), InputError);
    EXPECT_EQ(read_text(folder / "trajectory.xyz"), text);
    EXPECT_EQ(read_text(folder / "trajectory.pvd"), list);
  }
}

/// Makes a checkpoint with a different number in every place.
Checkpoint make_checkpoint() {
  Checkpoint checkpoint;
  checkpoint.scene = "0123456789abcdef";
  checkpoint.trajectory = {.frames = 7, .files = {{"trajectory.pvd", 567}, {"trajectory.xyz", 12345678901}}};
  checkpoint.wall = {.total = 1.0, .setup = 0.25, .output = 0.125};
  checkpoint.time = 0.1 + 0.2;
  for (int k = 0; k < 500; ++k) checkpoint.state.push_back(static_cast<std::byte>(k * k));
  return checkpoint;
}

std::string error_of(const Folder& folder, const std::string& fingerprint = "0123456789abcdef") {
  try {
    return read_checkpoint(folder.path(), fingerprint) ? "no error" : "no checkpoint";
  } catch (const InputError& error) {
    EXPECT_EQ(error.where(), (folder / "checkpoint").string());
    return error.what();
  }
}

TEST(CheckpointTest, ReadsBackBitByBit) {
  const Folder folder;
  const Checkpoint written = make_checkpoint();

  write_checkpoint(folder.path(), written);

  const Checkpoint read = read_checkpoint(folder.path(), written.scene).value();
  EXPECT_EQ(read.trajectory.frames, 7u);
  EXPECT_EQ(read.trajectory.files, written.trajectory.files);
  EXPECT_EQ(read.wall.output, 0.125);
  EXPECT_EQ(read.wall.total, 1.0);
  EXPECT_EQ(read.time, 0.1 + 0.2);
  EXPECT_EQ(read.state, written.state);
  EXPECT_EQ(list_names(folder.path()), std::vector<std::string>{"checkpoint"});
}

TEST(CheckpointTest, OnlyTheCheckpointOfTheRunIsTaken) {
  const Folder folder;
  EXPECT_EQ(error_of(folder), "no checkpoint");
  write_checkpoint(folder.path(), make_checkpoint());

  EXPECT_EQ(error_of(folder), "no error");
  EXPECT_EQ(error_of(folder, "another"), "belongs to another scene; run without --resume");
  const std::string text = read_text(folder / "checkpoint");
  write_text(folder / "checkpoint", text.substr(0, text.size() - 1));
  EXPECT_EQ(error_of(folder), "is damaged: its checksum is another one; run without --resume");
  write_text(folder / "checkpoint", text.substr(0, 100));
  EXPECT_EQ(error_of(folder), "is damaged: its checksum is another one; run without --resume");
}

// The checksum is one to one in each byte, so that no flip of one bit is left to luck. The test flips all bits of the
// first and the last line, and one bit of every seventh byte in between.
TEST(CheckpointTest, AFlippedBitIsSeen) {
  const Folder folder;
  write_checkpoint(folder.path(), make_checkpoint());
  const std::string good = read_text(folder / "checkpoint");
  const auto expect_seen = [&](std::size_t place, int bit) {
    std::string bad = good;
    bad[place] = static_cast<char>(bad[place] ^ (1 << bit));
    write_text(folder / "checkpoint", bad);
    const std::string error = error_of(folder);
    EXPECT_TRUE(error.starts_with("is damaged") || error.starts_with("is of another version") ||
                error.starts_with("is no checkpoint"))
        << "bit " << bit << " of byte " << place << ": " << error;
  };

  for (std::size_t place = 0; place < good.size(); ++place) {
    const bool is_in_a_line_of_ours = place < 19 || place + 26 >= good.size();
    for (int bit = 0; is_in_a_line_of_ours && bit < 8; ++bit) expect_seen(place, bit);
    if (!is_in_a_line_of_ours && place % 7 == 0) expect_seen(place, static_cast<int>(place % 8));
  }
  for (std::size_t size = 0; size < good.size(); size += 97) {
    write_text(folder / "checkpoint", good.substr(0, size));
    EXPECT_NE(error_of(folder), "no error") << size;
  }
  write_text(folder / "checkpoint", good + "x");
  EXPECT_NE(error_of(folder), "no error");
}

/// Returns a checkpoint's text with another number in its head, and the checksum that belongs to it.
std::string forge(const std::string& text, const std::string& key, const std::string& value) {
  std::string content = text.substr(0, text.rfind("checksum "));
  const std::size_t begin = content.find("\"" + key + "\":") + key.size() + 3;
  content.replace(begin, content.find_first_of(",}", begin) - begin, value);
  Checksum sum;
  sum.add(content);
  return content + "checksum " + sum.text() + "\n";
}

// The text is as another program might write it: whole, and yet no checkpoint of any run.
TEST(CheckpointTest, NumbersThatNoRunHasAreRefused) {
  const Folder folder;
  write_checkpoint(folder.path(), make_checkpoint());
  const std::string good = read_text(folder / "checkpoint");
  const auto refuses = [&](const std::string& key, const std::string& value) {
    write_text(folder / "checkpoint", forge(good, key, value));
    return error_of(folder) != "no error";
  };
  ASSERT_FALSE(refuses("frames", "8")) << "the forger knows his trade";

  for (const std::string key : {"frames", "trajectory.xyz", "trajectory.pvd"}) {
    for (const std::string value : {"-1", "1.5", "null", "\"1\"", "1e999", "18446744073709551616", "[]", "true"})
      EXPECT_TRUE(refuses(key, value)) << key << ": " << value;
  }
  for (const std::string key : {"time", "wall_total", "wall_setup", "wall_output"}) {
    for (const std::string value : {"null", "\"1\"", "1e999", "[]", "true"})
      EXPECT_TRUE(refuses(key, value)) << key << ": " << value;
  }
  EXPECT_TRUE(refuses("wall_total", "-0.5"));
  EXPECT_TRUE(refuses("frames", "0"));
  EXPECT_TRUE(refuses("frames", "568")) << "more than the list has bytes";
}

TEST(CheckpointTest, TheFingerprintSeesAllFilesAndTheirPoints) {
  const Folder folder;
  write_text(folder / "a.json", "{}");
  write_text(folder / "b.json", "{ }");
  write_text(folder / "drive.csv", "0, 0");
  const std::vector files{folder / "a.json", folder / "drive.csv"};
  System system = scenes::make_chain(1);
  const std::string fingerprint = make_fingerprint(files, system);

  EXPECT_EQ(make_fingerprint(files, scenes::make_chain(1)), fingerprint);
  EXPECT_NE(make_fingerprint(std::vector{folder / "b.json", folder / "drive.csv"}, system), fingerprint);
  system.positions[3] = std::nextafter(system.positions[3], 1.0);
  EXPECT_NE(make_fingerprint(files, system), fingerprint);
  write_text(folder / "drive.csv", "0, 1");
  EXPECT_NE(make_fingerprint(files, scenes::make_chain(1)), fingerprint);
}

TEST(CheckpointTest, ChangedFilesAndPointsAreNamed) {
  const Folder folder;
  write_text(folder / "a.json", "{}");
  write_text(folder / "drive.csv", "0, 0");
  const std::vector files{folder / "a.json", folder / "drive.csv"};
  System system = scenes::make_chain(1);
  Checkpoint checkpoint = make_checkpoint();
  checkpoint.scene = make_fingerprint(files, system);
  write_checkpoint(folder.path(), checkpoint);
  const auto error_now = [&] { return error_of(folder, make_fingerprint(files, system)); };
  ASSERT_EQ(error_now(), "no error");

  system.positions[3] += 1.0;
  EXPECT_EQ(error_now(),
            "is of an earlier version of the scene: the start of its points was changed; run without --resume");
  write_text(folder / "drive.csv", "0, 1");
  EXPECT_EQ(error_now(), "is of an earlier version of the scene: drive.csv was changed; run without --resume");
  EXPECT_EQ(error_of(folder, make_fingerprint(std::vector{folder / "a.json"}, system)),
            "belongs to another scene, of a.json, drive.csv, not of a.json; run without --resume");
}

std::vector<std::string> list_keys(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;  // sorted: json objects are
}

// The keys are the contract's list with `start` and `energy.work_of_forces`; `doubt` is the old name of
// `accuracy_warning`.
TEST(SummaryTest, HasTheKeysOfTheContract) {
  using Keys = std::vector<std::string>;
  const Folder folder;
  Simulation simulation = make_simulation();
  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  write_summary(folder.path(), {}, simulation);

  const json summary = read_json(folder / "summary.json");
  EXPECT_EQ(list_keys(summary), (Keys{"accuracy_warning",
                                      "certificate",
                                      "certificates",
                                      "contact_changes",
                                      "degrees_of_freedom",
                                      "doubt",
                                      "energy",
                                      "equations",
                                      "factorizations",
                                      "final",
                                      "form",
                                      "friction",
                                      "groups",
                                      "islands",
                                      "left_out",
                                      "method",
                                      "nearest_to_singular",
                                      "observables",
                                      "passages",
                                      "points",
                                      "rank",
                                      "rank_changes",
                                      "redundant",
                                      "rejected",
                                      "scene",
                                      "singular_passages",
                                      "solves",
                                      "source",
                                      "start",
                                      "start_correction",
                                      "steps",
                                      "stopped_by",
                                      "supports",
                                      "t_end",
                                      "t_reached",
                                      "tanor_version",
                                      "threads",
                                      "units",
                                      "violation",
                                      "wall_s"}));
  EXPECT_EQ(list_keys(summary["wall_s"]),
            (Keys{"assemble", "evaluate", "factor", "friction", "output", "setup", "solve", "total"}));
  EXPECT_EQ(list_keys(summary["final"]),
            (Keys{"accelerations", "multipliers", "positions", "reactions", "self_stress", "support_forces", "t",
                  "velocities"}));
  EXPECT_EQ(list_keys(summary["violation"]), (Keys{"acceleration_max", "position_max", "velocity_max"}));
  EXPECT_EQ(list_keys(summary["energy"]),
            (Keys{"drift_relative", "end", "kinetic", "largest_drift", "largest_drift_time", "potential",
                  "potential_at_start", "scale", "start", "work_of_forces", "work_of_friction", "work_of_impacts",
                  "work_of_potentials", "work_of_supports"}));
  EXPECT_EQ(list_keys(summary["certificate"]),
            (Keys{"bases_orthogonal", "certified_to", "checks", "forms_agree", "friction", "left_out",
                  "normal_identity", "orthogonality", "passed", "power_balance", "reciprocal_condition", "residual",
                  "second_factorization", "tangent_identity", "verdict"}));
  EXPECT_EQ(list_keys(summary["friction"]),
            (Keys{"contacts", "contraction_max", "error_bound", "first_several", "iterations_max", "iterations_mean",
                  "method_used", "residual_max", "several", "solves", "uniqueness", "uniqueness_reason"}));
}

TEST(SummaryTest, TellsWhatTheSimulationKnows) {
  const Folder folder;
  Simulation simulation = make_simulation();
  ASSERT_TRUE(simulation.advance_to(0.1).ok());

  RunFacts facts;
  facts.scene = "chain";
  facts.source = "inline";
  facts.threads = 2;
  facts.t_end = 0.5;
  write_summary(folder.path(), facts, simulation);

  const json summary = read_json(folder / "summary.json");
  EXPECT_EQ(summary["scene"], "chain");
  EXPECT_EQ(summary["source"], "inline");
  EXPECT_EQ(summary["threads"], 2);
  EXPECT_EQ(summary["t_end"], 0.5);
  EXPECT_EQ(summary["method"], "rk4");
  EXPECT_EQ(summary["points"], 4);
  EXPECT_EQ(summary["supports"], 1);
  EXPECT_EQ(summary["rank"], 3);
  EXPECT_EQ(summary["degrees_of_freedom"], 6);
  EXPECT_EQ(summary["t_reached"], 0.1);
  EXPECT_EQ(summary["final"]["t"], 0.1);
  EXPECT_EQ(summary["steps"], 10);
  const auto positions = simulation.positions();
  EXPECT_EQ(summary["final"]["positions"][3], std::vector<double>(positions.begin() + 9, positions.end()));
  EXPECT_EQ(summary["final"]["multipliers"].size(), 3u);
  EXPECT_LT(summary["certificate"]["residual"], 1e-12);
  EXPECT_TRUE(summary["certificate"]["tangent_identity"].is_null());
  EXPECT_TRUE(summary["energy"]["work_of_friction"].is_null());
  EXPECT_TRUE(summary["wall_s"]["friction"].is_null());
}

/// The chain's last bead slides on a rough floor.
System make_rough_chain(const Friction& friction) {
  System system = scenes::make_chain(3);
  system.constraints.push_back(Planes{"floor", {3}, Vector3{0, 0, 1}});
  system.velocities[10] = 0.5;
  system.friction = {friction};
  return system;
}

json summarise_friction(const System& system, const FrictionSummary& found) {
  return json::parse(describe_friction_summary(count_contacts(system), found).dump());
}

TEST(SummaryTest, TellsHowFrictionWasFound) {
  const FrictionSummary found{.solves = 8,
                              .iterations_mean = 2.5,
                              .iterations_max = 9,
                              .contraction_max = 0.75,
                              .error_bound = 1e-9,
                              .uniqueness = Uniqueness::Proven,
                              .method_used = FrictionMethod::Anderson,
                              .residual_max = 1e-13};

  EXPECT_EQ(summarise_friction(make_rough_chain(Coulomb{.at = {"floor"}, .coefficient = 0.3}), found),
            json({{"contacts", 1},
                  {"solves", 8},
                  {"iterations_mean", 2.5},
                  {"iterations_max", 9},
                  {"contraction_max", 0.75},
                  {"residual_max", 1e-13},
                  {"error_bound", 1e-9},
                  {"uniqueness", "proven"},
                  {"uniqueness_reason", nullptr},
                  {"several", 0},
                  {"first_several", nullptr},
                  {"method_used", "anderson"}}));
}

TEST(SummaryTest, UnneededNumbersOfFrictionAreNull) {
  const json friction = summarise_friction(make_rough_chain(Viscous{.at = {"floor"}, .coefficient = 2.0}), {});

  for (const char* key : {"iterations_mean", "iterations_max", "contraction_max", "residual_max", "error_bound",
                          "uniqueness", "method_used"}) {
    EXPECT_TRUE(friction[key].is_null()) << key;
  }
  EXPECT_EQ(friction["contacts"], 1);
}

TEST(SummaryTest, WorkAndTimeOfFrictionAreNumbersWhereThereIsSome) {
  const Folder folder;
  Simulation simulation(make_rough_chain(Coulomb{.at = {"floor"}, .coefficient = 0.3}),
                        {.method = Method::Rk4, .step = 0.01});

  write_summary(folder.path(), {}, simulation);

  const json summary = read_json(folder / "summary.json");
  EXPECT_TRUE(summary["energy"]["work_of_friction"].is_number());
  EXPECT_TRUE(summary["wall_s"]["friction"].is_number());
  EXPECT_EQ(summary["final"]["multipliers"].size(), 4u) << "as many as equations, also where the bead could stick";
}

TEST(SummaryTest, UncomputedNumbersAreNull) {
  const Folder folder;
  Simulation simulation = make_simulation();
  RunFacts facts;
  facts.has_started = false;

  write_summary(folder.path(), facts, simulation);

  const json summary = read_json(folder / "summary.json");
  for (const char* pointer :
       {"/rank", "/degrees_of_freedom", "/start_correction", "/start/position", "/start/velocity", "/final/t",
        "/final/positions", "/final/velocities", "/final/accelerations", "/final/multipliers", "/final/reactions",
        "/final/support_forces", "/violation/position_max", "/energy/start", "/energy/end", "/energy/drift_relative",
        "/certificate/residual", "/certificate/reciprocal_condition"}) {
    EXPECT_TRUE(summary[json::json_pointer(pointer)].is_null()) << pointer;
  }
}

TEST(SummaryTest, HasTheCertificateThatWasMadeOrNull) {
  const Folder folder;
  Simulation simulation = make_simulation();

  RunFacts facts;
  write_summary(folder.path(), facts, simulation);
  const json without = read_json(folder / "summary.json");
  facts.certificate = simulation.certify();
  write_summary(folder.path(), facts, simulation);

  const json summary = read_json(folder / "summary.json");
  EXPECT_TRUE(without["certificate"]["residual"].is_null());
  EXPECT_TRUE(without["certificate"]["verdict"].is_null());
  EXPECT_EQ(summary["certificate"]["residual"], facts.certificate->residual);
  EXPECT_EQ(summary["certificate"]["verdict"], facts.certificate->line());
  EXPECT_EQ(summary["certificate"]["checks"].size(), facts.certificate->checks.size());
  EXPECT_FALSE(summary["violation"]["position_max"].is_null());
}

TEST(SummaryTest, LargeArraysGoToFilesBesideIt) {
  const Folder folder;
  Simulation simulation = make_simulation(largest_inline + 1);

  write_summary(folder.path(), {}, simulation);

  const json summary = read_json(folder / "summary.json");
  EXPECT_EQ(summary["final"]["positions"], "final_positions.npy");
  EXPECT_EQ(summary["final"]["multipliers"], "final_multipliers.npy");
  const scene::NpyArray positions = read_npy(folder / "final_positions.npy");
  EXPECT_EQ(positions.shape, (std::vector<std::size_t>{largest_inline + 1, 3}));
  EXPECT_TRUE(std::equal(positions.numbers.begin(), positions.numbers.end(), simulation.positions().begin()));
  EXPECT_EQ(read_npy(folder / "final_multipliers.npy").shape, (std::vector<std::size_t>{largest_inline}));
}

}  // namespace
}  // namespace tanor::report
