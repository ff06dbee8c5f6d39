#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <tanor/cell.hpp>

#include "report/frame_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// An H5MD file (version 1.1, de Buyl, Colberg and Höfling, Comput. Phys. Commun. 185 (2014) 1546; MDAnalysis, OVITO,
/// VMD, h5py): `/particles/all` with box, mass, id, species (0: moves, 1: support), position, velocity, force (M w) and
/// constraint_force (K lambda); `/connectivity/rods`, pairs of rows of `/particles/all`; `/observables`: tension (a
/// number a rod), total_energy, position_violation, velocity_violation, and those of the scene, with `unit`, `parts`
/// and `members`.
///
/// The file is written in HDF5's mode for a single writer and many readers: each frame is complete before the file
/// counts it, and h5py opens it with `swmr=True` while the run goes on. A run that was killed leaves a mark in the file
/// that plain readers refuse; `h5clear -s` or a resumed run removes it.
class H5mdTrajectory : public FrameFile {
 public:
  struct Sample {
    std::string title;               ///< name of the scene
    std::span<const double> masses;  ///< m, kg
    std::optional<Cell> cell;
    std::span<const Observed> observables{};
    bool is_compressed = false;
  };

  /// Creates a new file; `shown` must outlive this object. Throws WriteError.
  H5mdTrajectory(const std::filesystem::path& path, const ShownParts* shown, const Sample& sample);
  /// Continues after `frames` of an existing file. Throws InputError if it is not such a file with as many frames.
  H5mdTrajectory(const std::filesystem::path& path, const ShownParts* shown, std::uint64_t frames,
                 std::span<const Observed> observables = {});
  ~H5mdTrajectory() override;

  void write(const Frame& frame) override;
  std::uint64_t mark() const override;
  void cut(std::uint64_t frames) override;
  void synchronize() override;

 private:
  struct File;
  std::unique_ptr<File> file_;
};

}  // namespace tanor::report
