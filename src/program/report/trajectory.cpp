#include "report/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <system_error>

#include "report/compression.hpp"
#include "report/frame_file.hpp"
#include "report/module.hpp"
#include "report/output_file.hpp"
#include "report/shown_parts.hpp"
#include "report/text_formats.hpp"
#include "report/vtp_frame.hpp"

namespace tanor::report {

namespace fs = std::filesystem;
using scene::TrajectoryFormat;

namespace {

constexpr const char* packed = ".gz";

std::unique_ptr<FrameFile> open_vtp(const FrameFileRequest& request) {
  return std::make_unique<VtpTrajectory>(request.path.parent_path(), request.shown, request.is_compressed,
                                         request.mark);
}

/// A file whose mark tells how far it is written.
struct NamedFile {
  TrajectoryFormat format;
  const char* name;
  bool is_packed;                                               ///< if the user wants compression
  std::unique_ptr<FrameFile> (*open)(const FrameFileRequest&);  ///< null if a module opens it

  std::string name_if(bool is_compressed) const {
    return std::string(name) + (is_compressed && is_packed ? packed : "");
  }
};
constexpr NamedFile named_files[] = {{TrajectoryFormat::Xyz, "trajectory.xyz", true, open_xyz},
                                     {TrajectoryFormat::Lammps, "trajectory.dump", true, open_lammps_dump},
                                     {TrajectoryFormat::Lammps, "trajectory_rods.dump", true, open_lammps_rod_dump},
                                     {TrajectoryFormat::Csv, "trajectory.csv", true, open_csv},
                                     {TrajectoryFormat::Vtp, VtpTrajectory::list_name, false, open_vtp},
                                     {TrajectoryFormat::H5md, "trajectory.h5", false, nullptr},
                                     {TrajectoryFormat::Npz, "trajectory.npz", false, nullptr}};
constexpr NamedFile observables_file{TrajectoryFormat::Csv, observables_name, false, open_observables};

void require_size(const fs::path& path, std::uint64_t size) {
  std::error_code error;
  const std::uintmax_t found = fs::file_size(path, error);
  if (error) throw InputError(path.string(), "is missing, of the run that is to go on; run without --resume");
  if (found < size) throw InputError(path.string(), "is shorter than the checkpoint says; run without --resume");
}

/// Returns the files that a run with these options writes.
std::vector<NamedFile> choose_files(const TrajectoryOptions& options, const ShownParts& shown) {
  std::vector<NamedFile> chosen;
  for (const TrajectoryFormat format : options.formats.files)
    for (const NamedFile& each : named_files)
      if (each.format == format && (each.open != open_lammps_rod_dump || !shown.rods.empty())) chosen.push_back(each);
  if (!options.observables.empty()) chosen.push_back(observables_file);
  return chosen;
}

/// Requires that the files of a folder hold everything that the mark promises, before any of them is changed.
void require_marked(const fs::path& directory, const TrajectoryOptions& options, const ShownParts& shown,
                    const TrajectoryMark& mark) {
  std::vector<std::string> names, marked;
  for (const NamedFile& each : choose_files(options, shown)) names.push_back(each.name_if(options.formats.compression));
  std::ranges::sort(names);
  for (const auto& [name, size] : mark.files) marked.push_back(name);
  if (marked != names)
    throw InputError(directory.string(), fmt::format("holds a run that writes {}, and goes on with these alone, not {}",
                                                     fmt::join(marked, ", "), fmt::join(names, ", ")));
  // Marks in frames pass this check too, since a file has more bytes than frames.
  for (const auto& [name, size] : mark.files) require_size(directory / name, size);
  if (!mark.files.contains(VtpTrajectory::list_name)) return;
  for (std::size_t k = 0; k < mark.frames; ++k) require_size(directory / VtpTrajectory::name_frame(k), 1);
}

/// Returns the function that opens files of this format, from its module.
OpenFrameFile* load_opener(TrajectoryFormat format) {
  const std::string name(name_of(format)),
      missing = fmt::format("found {}, which this tanor was built without ({})", name,
                            format == TrajectoryFormat::H5md ? "libhdf5-dev" : "libzip-dev");
  return reinterpret_cast<OpenFrameFile*>(load_function("tanor_" + name, open_symbol, missing));
}

}  // namespace

void require_formats(const TrajectoryOptions& options, std::size_t num_points, double expected_frames) {
  for (const TrajectoryFormat format : options.formats.files) {
    // A module that is missing or cannot be loaded is told before any result is replaced.
    try {
      if (format == TrajectoryFormat::H5md || format == TrajectoryFormat::Npz) (void)load_opener(format);
    } catch (const InputError& error) {
      throw InputError("/motion/trajectory", error.what());
    }
    constexpr double most = 2e9;  // bytes
    const std::size_t shown = options.points.empty() ? num_points : options.points.size();
    const double needed = expected_frames * (9.0 * sizeof(double) * static_cast<double>(shown));
    if (format == TrajectoryFormat::Npz && needed > most)
      throw InputError("/motion/trajectory",
                       fmt::format("found npz, which keeps all frames in memory, {:.1f} GB here; wanted at most {:.0f} "
                                   "GB: fewer output_points, or h5md",
                                   1e-9 * needed, 1e-9 * most));
  }
  if (options.formats.compression && !has_compression())
    throw InputError("/motion/compression", "found true, which this tanor was built without (zlib1g-dev)");
}

std::vector<fs::path> list_trajectory(const fs::path& directory) {
  std::vector<fs::path> files = list_frames(directory / VtpTrajectory::frame_folder);
  for (const NamedFile& each : named_files)
    for (const bool is_compressed : {false, true})
      if (each.is_packed || !is_compressed) files.push_back(directory / each.name_if(is_compressed));
  files.push_back(directory / observables_name);
  return files;
}

std::vector<fs::path> list_frames(const fs::path& frames) {
  std::vector<fs::path> files;
  std::error_code error;  // a missing folder has no frames
  for (const fs::directory_entry& entry : fs::directory_iterator(frames, error)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("frame_") && (name.ends_with(".vtp") || name.ends_with(".vtp.part")))
      files.push_back(entry.path());
  }
  return files;
}

Trajectory::Trajectory(const fs::path& directory, const System& system, const TrajectoryOptions& options,
                       const TrajectoryMark& mark)
    : shown_(std::make_unique<ShownParts>(choose_parts(system, options.points))),
      t_start_(options.t_start),
      without_picture_(list_guides_without_picture(system, *shown_, t_start_)),
      frames_(mark.frames) {
  for (const Index point : shown_->points)
    masses_.push_back(system.masses.empty() ? 1.0 : system.masses[static_cast<std::size_t>(point)]);
  const std::vector<bool> is_held = find_held_points(system);
  has_held_points_ =
      std::ranges::any_of(shown_->points, [&](Index point) { return is_held[static_cast<std::size_t>(point)]; });
  if (mark.frames > 0) require_marked(directory, options, *shown_, mark);
  open_files(directory, options, mark);
}

void Trajectory::open_files(const fs::path& directory, const TrajectoryOptions& options, const TrajectoryMark& mark) {
  for (const NamedFile& each : choose_files(options, *shown_)) {
    const std::string name = each.name_if(options.formats.compression);
    const auto before = mark.files.find(name);
    const FrameFileRequest request{.path = directory / name,
                                   .shown = shown_.get(),
                                   .title = options.title,
                                   .masses = masses_,
                                   .cell = options.cell,
                                   .observables = options.observables,
                                   .units = options.units,
                                   .is_compressed = options.formats.compression,
                                   .mark = before == mark.files.end() ? 0 : before->second};
    std::unique_ptr<FrameFile>& file = files_[name];
    if (each.open)
      file = each.open(request);
    else
      load_opener(each.format)(request, &file);
  }
}

/// Copies the rows of the shown points and rods from the simulation.
void Trajectory::gather(const Simulation& simulation) {
  gather_points(*shown_, simulation.positions(), &positions_);
  gather_points(*shown_, simulation.velocities(), &velocities_);
  gather_points(*shown_, simulation.accelerations(), &accelerations_);
  gather_points(*shown_, simulation.reactions(), &reactions_);
  forces_ = accelerations_;
  for (std::size_t k = 0; k < forces_.size(); ++k) forces_[k] *= masses_[k / 3];
  tensions_ = find_tensions(*shown_, simulation.multipliers());
  if (has_held_points_)
    guide_forces_ =
        find_guide_forces(*shown_, positions_, tensions_, simulation.reactions(), simulation.support_forces());
  if (const std::vector<double> stress = simulation.self_stress(); !stress.empty())
    tensions_ = find_tensions(*shown_, unique_multipliers(simulation.multipliers(), stress));
}

void Trajectory::write_frame(Simulation& simulation, std::span<const double> friction) {
  gather(simulation);
  if (!friction.empty()) gather_points(*shown_, friction, &friction_);
  const MotionReport& report = simulation.report();
  const Frame frame{.number = frames_,
                    .steps = report.steps,
                    .time = simulation.time(),
                    .positions = positions_,
                    .velocities = velocities_,
                    .accelerations = accelerations_,
                    .forces = forces_,
                    .reactions = reactions_,
                    .tensions = tensions_,
                    .guide_forces = guide_forces_,
                    .friction_forces = friction_,
                    .observables = simulation.observe(),
                    .guides = list_guides(simulation.system(), *shown_, without_picture_, t_start_, simulation.time(),
                                          simulation.passages()),
                    .gravity = find_gravity(simulation.system()),
                    .gone = find_gone(*shown_, simulation.passages()),
                    .energy = report.energy.now,
                    .position_violation = report.violation.position,
                    .velocity_violation = report.violation.velocity};
  const TrajectoryMark before = mark();
  try {
    for (const auto& [name, file] : files_) file->write(frame);
  } catch (const WriteError&) {
    for (const auto& [name, file] : files_)
      if (file->mark() > before.files.at(name)) file->cut(before.files.at(name));
    throw;
  }
  ++frames_;
}

void Trajectory::synchronize() {
  for (const auto& [name, file] : files_) file->synchronize();
}

TrajectoryMark Trajectory::mark() const {
  TrajectoryMark mark{frames_, {}};
  for (const auto& [name, file] : files_) mark.files[name] = file->mark();
  return mark;
}

}  // namespace tanor::report
