/// Reads the bytes of a checkpoint, and those of a simulation inside it. An input is laid over a good checkpoint with
/// an
/// exclusive or, so that zeros are the good one. The checksums are mended, so that the code behind them is tried, too.
///
///     byte 0: which system and method; bit 7: the checksums stay wrong      bytes 1, 2: bytes cut off at the end

#include "report/checkpoint.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "base/checksum.hpp"
#include "scene/scene.hpp"

#include "small_scene.hpp"
#include "target.hpp"

namespace {

using namespace tanor;
using namespace tanor::detail;

constexpr std::size_t size_of_sum = 8;

/// A run that was stopped after two steps, and a simulation to go on with.
struct Stopped {
  scene::Scene scene;
  std::string file;  ///< its checkpoint
};

Stopped stop(const std::string& scene_keys, const std::filesystem::path& folder) {
  Stopped run{scene::parse_scene(R"({"tanor_scene": 1, "solver": {"threads": 1}, )" + scene_keys + "}", "s.json"), {}};
  Simulation simulation(run.scene.system, run.scene.motion, run.scene.solver);
  fuzz::advance_few_steps(&simulation, 1.0);
  report::write_checkpoint(folder,
                           {.scene = "fuzz",
                            .time = simulation.time(),
                            .trajectory = {.frames = 1, .files = {{"trajectory.xyz", 100}, {"trajectory.pvd", 100}}},
                            .wall = {},
                            .state = simulation.save()},
                           report::Wait::No);
  std::ifstream stream(folder / "checkpoint", std::ios::binary);
  run.file.assign(std::istreambuf_iterator<char>(stream), {});
  return run;
}

const std::vector<Stopped>& stopped_runs(const std::filesystem::path& folder) {
  const std::string chain = R"("generate": {"kind": "chain", "count": 3, "anchored": true},
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], )";
  const std::string rough = R"("points": {"positions": [[0, 0, 0], [1, 0, 0]], "velocities": [[1, 0, 0], [0, 0, 0]]},
    "constraints": [{"name": "floor", "kind": "plane", "points": "all", "normal": [0, 0, 1], "offset": 0}],
    "friction": [{"kind": "coulomb", "at": "floor", "coefficient": 0.2}],
    "forces": [{"kind": "gravity", "acceleration": [0, 0, -9.81]}], )";
  static const std::vector<Stopped> runs{
      stop(chain + R"("motion": {"method": "taylor"})", folder),
      stop(chain + R"("motion": {"method": "dop853"})", folder),
      stop(chain + R"("motion": {"method": "rattle", "step": 1e-3})", folder),
      stop(chain + R"("motion": {"method": "radau5"})", folder),
      stop(rough + R"("motion": {"method": "dop853"})", folder),
  };
  return runs;
}

/// Mends both sums: that of the simulation's bytes (the last eight before the line "checksum …") and that of the file.
void mend_checksums(std::string* file) {
  constexpr std::string_view last = "checksum ";
  const std::size_t end = file->rfind(last) != std::string::npos ? file->rfind(last) : file->size();
  file->resize(end);
  const std::size_t head = file->find('\n', file->find('\n') + 1);
  if (head != std::string::npos && file->size() - head - 1 > size_of_sum) {
    Checksum sum;
    sum.add(std::string_view(*file).substr(head + 1, file->size() - head - 1 - size_of_sum));
    const auto bytes = std::bit_cast<std::array<char, size_of_sum>>(sum.value());
    file->replace(file->size() - size_of_sum, size_of_sum, bytes.data(), size_of_sum);
  }
  Checksum sum;
  sum.add(std::string_view(*file));
  *file += std::string(last) + sum.text() + "\n";
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < fuzz::Overlaid<Stopped>::head) return 0;
  static const fuzz::InputFile file(".none");
  fuzz::Overlaid overlaid(stopped_runs(file.folder()), data, size);
  const Stopped& run = overlaid.good;
  if (overlaid.mends_checksum) mend_checksums(&overlaid.bytes);
  std::ofstream(file.folder() / "checkpoint", std::ios::binary) << overlaid.bytes;

  fuzz::takes([&] {
    const auto checkpoint = report::read_checkpoint(file.folder(), "fuzz");
    if (!checkpoint) return;
    Simulation simulation(run.scene.system, run.scene.motion, run.scene.solver);
    simulation.restore(checkpoint->state);
    fuzz::advance_few_steps(&simulation, simulation.time() + 1.0);
  });
  return 0;
}
