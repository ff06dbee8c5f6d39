/// Reads the bytes that a page keeps of a run that goes on. An input is laid over a good recording with an exclusive
/// or, so that zeros are the good one. The checksum is mended, so that the code behind it is tried, too.
///
///     byte 0: which system; bit 7: the checksum stays wrong      bytes 1, 2: bytes cut off in front of it

#include "report/recording.hpp"

#include <fstream>
#include <string>
#include <vector>

#include "base/checksum.hpp"
#include "scene/scene.hpp"

#include "small_scene.hpp"
#include "target.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

constexpr std::string_view last_words = "checksum ";

/// A run that was stopped after two steps, and what lies in its folder without the last line.
struct Stopped {
  scene::Scene scene;
  std::vector<std::byte> state;
  std::string file;
};

report::Recording make_recording(const scene::Scene& scene) {
  return {scene.system, {}, {.duration = 1.0, .every = 0.1}};
}

Stopped stop(const std::string& scene_keys, const std::filesystem::path& folder) {
  Stopped run{
      scene::parse_scene(R"({"tanor_scene": 1, "solver": {"threads": 1}, )" + scene_keys + "}", "s.json"), {}, {}};
  Simulation simulation(run.scene.system, run.scene.motion, run.scene.solver);
  report::Recording recording = make_recording(run.scene);
  recording.take_frame(simulation);
  fuzz::advance_few_steps(&simulation, 1.0);
  recording.take_step(simulation.report());
  recording.take_frame(simulation);
  report::write_recording(folder, "fuzz", simulation.time(), recording);
  run.state = simulation.save();
  std::ifstream stream(folder / report::recording_name, std::ios::binary);
  run.file.assign(std::istreambuf_iterator<char>(stream), {});
  run.file.resize(run.file.rfind(last_words));
  return run;
}

const std::vector<Stopped>& stopped_runs(const std::filesystem::path& folder) {
  const std::string chain = R"("generate": {"kind": "chain", "count": 3, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"method": "rattle", "step": 1e-3})";
  const std::string rough = R"("points": {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[1, 0, 0], [0, 0, 0]]},
    "constraints": [{"name": "floor", "kind": "plane", "points": "all", "normal": [0, 0, 1], "offset": 0}],
    "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.2}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], "motion": {"method": "dop853"})";
  static const std::vector<Stopped> runs{stop(chain, folder), stop(rough, folder)};
  return runs;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < fuzz::Overlaid<Stopped>::head) return 0;
  static const fuzz::InputFile file(".none");
  fuzz::Overlaid overlaid(stopped_runs(file.folder()), data, size);
  const Stopped& run = overlaid.good;
  Checksum sum;
  sum.add(std::string_view(overlaid.bytes));
  overlaid.bytes += std::string(last_words) + (overlaid.mends_checksum ? sum.text() : "0123456789abcdef") + "\n";
  std::ofstream(file.folder() / report::recording_name, std::ios::binary) << overlaid.bytes;

  fuzz::takes([&] {
    Simulation simulation(run.scene.system, run.scene.motion, run.scene.solver);
    simulation.restore(run.state);
    report::Recording recording = make_recording(run.scene);
    (void)report::read_recording(file.folder(), "fuzz", simulation, &recording);
    recording.take_step(simulation.report());
    recording.take_frame(simulation);
    // A page packs these arrays.
    const std::size_t held = 3 * recording.held().size();
    for (const report::RecordedFrame& each : recording.frames()) {
      bool fits = each.positions.size() == 3 * recording.shown().num_points &&
                  each.tensions.size() == recording.shown().rods.size() && each.normal_reactions.size() == held &&
                  (each.tangent_reactions.empty() || each.tangent_reactions.size() == held) &&
                  each.guides.size() == recording.guides().size();
      for (std::size_t k = 0; fits && k < each.guides.size(); ++k)
        fits = each.guides[k].size() == recording.guides()[k].numbers.size();
      if (!fits) std::abort();
    }
    (void)recording.steps();
  });
  return 0;
}
