#include "report/trajectory.hpp"

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <system_error>

#include "report/output_file.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

constexpr const char* xyz_name = "trajectory.xyz";
constexpr const char* collection_name = "trajectory.pvd";
constexpr const char* frame_folder = "trajectory";
constexpr std::string_view list_head =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
constexpr std::string_view list_tail = "</Collection>\n</VTKFile>\n";

std::string frame_name(std::size_t frame) {
  return fmt::format("{}/frame_{:06}.vtp", frame_folder, frame);
}

fs::path make_frame_folder(const fs::path& directory) {
  make_folder(directory / frame_folder);
  return directory;
}

void require_size(const fs::path& path, std::uint64_t size) {
  std::error_code error;
  const std::uintmax_t found = fs::file_size(path, error);
  if (error || found < size) {
    throw InputError(path.string(), "is shorter than the checkpoint says; run without --resume");
  }
}

/// Checks that the files of a folder hold all that the mark promises. Nothing there is touched before that is known.
fs::path require_marked(const fs::path& directory, const TrajectoryMark& mark) {
  require_size(directory / xyz_name, mark.xyz_bytes);
  require_size(directory / collection_name, mark.pvd_bytes);
  return make_frame_folder(directory);
}

}  // namespace

void remove_trajectory(const fs::path& directory) {
  remove_file(directory / xyz_name);
  remove_file(directory / collection_name);
  std::error_code error;  // without a folder there are no frames
  for (const fs::directory_entry& entry : fs::directory_iterator(directory / frame_folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("frame_") && (name.ends_with(".vtp") || name.ends_with(".vtp.part"))) {
      remove_file(entry.path());
    }
  }
}

Trajectory::Trajectory(const fs::path& directory, const System& system, std::span<const Index> chosen)
    : directory_(make_frame_folder(directory)),
      shown_(choose_parts(system, chosen)),
      list_(directory / collection_name, list_head, list_tail),
      xyz_(directory / xyz_name) {}

Trajectory::Trajectory(const fs::path& directory, const System& system, std::span<const Index> chosen,
                       const TrajectoryMark& mark)
    : directory_(require_marked(directory, mark)),
      shown_(choose_parts(system, chosen)),
      frames_(mark.frames),
      list_(directory / collection_name, mark.pvd_bytes, list_tail),
      xyz_(directory / xyz_name, mark.xyz_bytes) {}

void Trajectory::write_frame(const Simulation& simulation) {
  gather_points(shown_, simulation.positions(), &positions_);
  gather_points(shown_, simulation.velocities(), &velocities_);
  gather_points(shown_, simulation.accelerations(), &accelerations_);

  const double time = simulation.time();
  const std::string name = frame_name(frames_);
  const TrajectoryMark before = mark();
  try {
    write_vtp(directory_ / name, shown_, {time, positions_, velocities_, accelerations_, simulation.multipliers()});
    xyz_.write(time, shown_, positions_, velocities_);
    list_.append(fmt::format("<DataSet timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", time, name));
  } catch (const WriteError&) {
    if (xyz_.size() > before.xyz_bytes) xyz_.cut(before.xyz_bytes);
    std::error_code ignored;
    fs::remove(directory_ / name, ignored);
    throw;
  }
  ++frames_;
}

void Trajectory::synchronize() {
  xyz_.synchronize();
  list_.synchronize();
}

}  // namespace tanor::report
