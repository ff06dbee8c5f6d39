#pragma once

#include <filesystem>
#include <vector>

#include "report/stored_frame.hpp"

namespace tanor::report {

/// Reads a frame that `write_vtp` has written. Throws InputError, naming the file, if it is damaged or another
/// program's.
StoredFrame read_vtp(const std::filesystem::path& path);

struct ListedFrame {
  double time = 0.0;           ///< s
  std::filesystem::path file;  ///< the frame's file
};

/// Reads the list of frames that `VtpTrajectory` writes, in the order of time. Throws InputError as `read_vtp` does.
std::vector<ListedFrame> read_frame_list(const std::filesystem::path& path);

}  // namespace tanor::report
