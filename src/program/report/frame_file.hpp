#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/observables.hpp>
#include <tanor/system.hpp>

#include "report/guides.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// One instant of a motion as a trajectory shows it: rows of m points and R rods, in their order in ShownParts.
struct Frame {
  std::size_t number = 0;                                     ///< 0, 1, … in the trajectory
  std::size_t steps = 0;                                      ///< of the method until then
  double time = 0.0;                                          ///< s
  bool is_at_rest = false;                                    ///< no part of a motion
  std::span<const double> positions{};                        ///< 3m, m
  std::span<const double> velocities{};                       ///< 3m, m/s
  std::span<const double> accelerations{};                    ///< 3m, m/s^2
  std::span<const double> forces{};                           ///< 3m, N: M w
  std::span<const double> reactions{};                        ///< 3m, N: K lambda
  std::span<const double> tensions{};                         ///< R, N: -lambda
  std::span<const double> guide_forces{};                     ///< 3m, N; empty if no point is held
  std::span<const double> friction_forces{};                  ///< 3m, N; empty if there is no friction
  std::span<const Observed> observables{};                    ///< at this instant
  std::vector<Guide> guides{};                                ///< at their positions in this frame
  Vector3 gravity{};                                          ///< m/s^2
  GoneParts gone{};                                           ///< since when, where events took something out
  double energy = 0.0;                                        ///< J, kinetic and potential
  double position_violation = 0.0, velocity_violation = 0.0;  ///< largest so far, relative
};

/// Returns the edges a, b and c of a cell, m, one after the other.
inline std::array<double, 9> edges_of(const Cell& cell) {
  return {cell.xx, 0.0, 0.0, cell.xy, cell.yy, 0.0, cell.xz, cell.yz, cell.zz};
}

/// A file, or several files, to which frames are appended.
///
/// Whenever the program stops, the file can be read: each frame is in it completely or not at all.
class FrameFile {
 public:
  virtual ~FrameFile() = default;

  /// Appends a frame. Throws WriteError; a `cut` to the mark before it then restores the file.
  virtual void write(const Frame& frame) = 0;
  /// Returns how far the file is written, in bytes or in frames; not 0 once there is a frame.
  virtual std::uint64_t mark() const = 0;
  /// Cuts the file back to an earlier mark, the one before the last frame.
  virtual void cut(std::uint64_t mark) = 0;
  /// Ensures that all frames outlive the program and, if the format can, the machine. Throws WriteError.
  virtual void synchronize() = 0;
};

/// Describes a file that is to be opened.
struct FrameFileRequest {
  std::filesystem::path path;
  const ShownParts* shown = nullptr;  ///< must outlive the file
  std::string title{};                ///< name of the scene
  std::span<const double> masses{};   ///< m, kg
  std::optional<Cell> cell{};
  std::span<const Observed> observables{};
  Units units{};
  bool is_compressed = false;
  std::uint64_t mark = 0;  ///< 0 for a new file, else the mark after which an existing file continues
};

/// Opens a file of a format that needs a library of its own (HDF5, libzip). Throws WriteError, or InputError if an
/// existing file has fewer frames. These formats are modules, `tanor_h5md` and `tanor_npz`, in src/program/formats.
/// Only a run that writes them loads them: HDF5 alone brings thirty libraries, and their loading took as long as
/// everything else that a short run does.
using OpenFrameFile = void(const FrameFileRequest&, std::unique_ptr<FrameFile>* opened);
/// The name of that function in each module.
inline constexpr const char* open_symbol = "tanor_open_frame_file";

}  // namespace tanor::report
