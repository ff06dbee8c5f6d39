#include "report/trajectory.hpp"

#include <fmt/format.h>

#include <fstream>
#include <system_error>

#include "report/output_file.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {

namespace fs = std::filesystem;

namespace {

constexpr const char* xyz_name = "trajectory.xyz";
constexpr const char* collection_name = "trajectory.pvd";
constexpr const char* frame_folder = "trajectory";
constexpr std::string_view entry_start = "<DataSet ";

std::string frame_name(std::size_t frame) {
  return fmt::format("{}/frame_{:06}.vtp", frame_folder, frame);
}

/// Removes the frames of an earlier run, which no list will name any more.
void remove_frames(const fs::path& directory) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory / frame_folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("frame_") && name.find(".vtp") != std::string::npos) remove_file(entry.path());
  }
}

fs::path make_empty(const fs::path& directory) {
  remove_frames(directory);
  remove_file(directory / collection_name);
  make_folder(directory / frame_folder);
  return directory / xyz_name;
}

/// The trajectory's file, when it holds all that the mark promises.
fs::path require_marked(const fs::path& directory, const TrajectoryMark& mark) {
  const fs::path path = directory / xyz_name;
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size < mark.xyz_bytes) {
    throw InputError(path.string(), "is shorter than the checkpoint says; run without --resume");
  }
  return path;
}

/// The first `count` entries of an earlier list of frames.
std::vector<std::string> read_entries(const fs::path& path, std::size_t count) {
  std::vector<std::string> entries;
  std::ifstream stream(path);
  for (std::string line; entries.size() < count && std::getline(stream, line);) {
    if (line.starts_with(entry_start)) entries.push_back(line + '\n');
  }
  if (entries.size() < count) {
    throw InputError(path.string(), "names fewer frames than the checkpoint says; run without --resume");
  }
  return entries;
}

}  // namespace

Trajectory::Trajectory(const fs::path& directory, const System& system, std::span<const Index> chosen)
    : directory_(directory), shown_(choose_parts(system, chosen)), xyz_(make_empty(directory)) {}

Trajectory::Trajectory(const fs::path& directory, const System& system, std::span<const Index> chosen,
                       const TrajectoryMark& mark)
    : directory_(directory),
      shown_(choose_parts(system, chosen)),
      entries_(read_entries(directory / collection_name, mark.frames)),
      xyz_(require_marked(directory, mark), mark.xyz_bytes) {
  make_folder(directory / frame_folder);
}

void Trajectory::write_frame(const Simulation& simulation) {
  gather_points(shown_, simulation.positions(), &positions_);
  gather_points(shown_, simulation.velocities(), &velocities_);
  gather_points(shown_, simulation.accelerations(), &accelerations_);

  const double time = simulation.time();
  const std::string name = frame_name(entries_.size());
  write_vtp(directory_ / name, shown_, {time, positions_, velocities_, accelerations_, simulation.multipliers()});
  xyz_.write(time, shown_, positions_, velocities_);
  entries_.push_back(fmt::format("{}timestep=\"{}\" group=\"\" part=\"0\" file=\"{}\"/>\n", entry_start, time, name));
}

void Trajectory::write_collection() {
  replace_file(directory_ / collection_name, [&](OutputFile* file) {
    file->write("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
    for (const std::string& entry : entries_) file->write(entry);
    file->write("</Collection>\n</VTKFile>\n");
  });
}

}  // namespace tanor::report
