#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <filesystem>
#include <span>

#include "report/growing_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// One file of extended XYZ frames (OVITO, ASE): a line a point with position and velocity, 10 significant digits
/// (the .vtp frames have all). Every frame is complete in the file before the next one begins.
///
/// The species are "C" for points that move and "X" for supports: names that every reader of the format knows.
class XyzTrajectory {
 public:
  explicit XyzTrajectory(const std::filesystem::path& path);
  /// Opens an existing file and goes on behind its first `size` bytes.
  XyzTrajectory(const std::filesystem::path& path, std::uint64_t size);

  /// `positions` and `velocities` of the shown points, 3m. Throws WriteError; the file then ends with the frame before.
  void write(double time, const ShownParts& shown, std::span<const double> positions,
             std::span<const double> velocities);

  /// Removes what stands behind the first `size` bytes.
  void cut(std::uint64_t size) { file_.cut(size); }
  void synchronize() { file_.synchronize(); }

  std::uint64_t size() const { return file_.body_size(); }

 private:
  GrowingFile file_;
  fmt::memory_buffer buffer_;
};

}  // namespace tanor::report
