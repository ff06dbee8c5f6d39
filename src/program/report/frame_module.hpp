#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <tanor/system.hpp>

#include "report/frame_file.hpp"
#include "report/shown_parts.hpp"

/// \file Trajectories that need a library of their own (HDF5, libzip) are modules, `tanor_h5md` and `tanor_npz`, in
/// src/program/formats. Only a run that writes them loads them: HDF5 alone brings thirty libraries, and their loading
/// took as long as everything else that a short run does.
namespace tanor::report {

/// Describes the file that a module opens.
struct FrameFileRequest {
  std::filesystem::path path;
  const ShownParts* shown;         ///< must outlive the file
  std::string title;               ///< name of the scene
  std::span<const double> masses;  ///< m, kg
  std::optional<Cell> cell;
  std::span<const Observed> observables;
  Units units;
  bool is_compressed;
  std::uint64_t frames;  ///< 0 for a new file, else the frames after which an existing file continues
};

/// Opens the file. Throws WriteError, or InputError if an existing file has fewer frames.
using OpenFrameFile = void(const FrameFileRequest&, std::unique_ptr<FrameFile>* opened);
/// The name of that function in each module.
inline constexpr const char* open_symbol = "tanor_open_frame_file";

}  // namespace tanor::report
