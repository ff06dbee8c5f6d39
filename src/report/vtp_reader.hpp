#pragma once

#include <filesystem>
#include <vector>

#include "report/stored_frame.hpp"

namespace tanor::report {

/// Reads a frame that `write_vtp` has written. Throws InputError, with the file, where it is damaged or another
/// program's.
StoredFrame read_vtp(const std::filesystem::path& path);

struct ListedFrame {
  double time = 0.0;           ///< s
  std::filesystem::path file;  ///< of the frame
};

/// The list of frames that `VtpTrajectory` writes, in the order of time. Throws InputError likewise.
std::vector<ListedFrame> read_frame_list(const std::filesystem::path& path);

}  // namespace tanor::report
