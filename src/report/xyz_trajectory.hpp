#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <span>

#include "report/output_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// One file of extended XYZ frames (OVITO, ASE): a line a point with position and velocity, 10 significant digits
/// (the .vtp frames have all). Every frame is complete in the file before the next one begins.
///
/// The species are "C" for points that move and "X" for supports: names that every reader of the format knows.
class XyzTrajectory {
 public:
  explicit XyzTrajectory(const std::filesystem::path& path);
  /// Goes on behind the first `size` bytes of an existing file.
  XyzTrajectory(const std::filesystem::path& path, std::uint64_t size);

  /// `positions` and `velocities` of the shown points, 3m.
  void write(double time, const ShownParts& shown, std::span<const double> positions,
             std::span<const double> velocities);

  std::uint64_t size() const { return file_.size(); }

 private:
  OutputFile file_;
  fmt::memory_buffer buffer_;
};

}  // namespace tanor::report
