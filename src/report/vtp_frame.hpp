#pragma once

#include <filesystem>

#include "report/frame_file.hpp"
#include "report/growing_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// Writes one frame as VTK polydata (ParaView): points with `velocity` and `acceleration`, `support` (1: it is one)
/// and, where points are held, `guide_force` (what guides and supports do to them), with friction `friction_force`;
/// rods as lines with `tension`, and points without a rod as one vertex cell, so that they are seen too (its tension is
/// NaN: there is none). A rod with an offset (periodic image) ends at an image of its second point, which follows the
/// points in the file with the velocity and acceleration of its own. Guides are arrays of numbers in the field data,
/// named "guide <kind> <name>", and so is "gravity". `read_vtp` reads a frame back. Binary, all digits: "appended raw"
/// arrays, each led by its number of bytes, or by those of its compressed blocks.
void write_vtp(const std::filesystem::path& path, const ShownParts& shown, const Frame& frame,
               bool is_compressed = false);

/// `trajectory.pvd`, the list of frames, and `trajectory/frame_*.vtp`. A frame is complete before the list names it.
class VtpTrajectory : public FrameFile {
 public:
  /// `shown` must outlive it. `mark`: bytes of the list, 0 for a new one.
  VtpTrajectory(const std::filesystem::path& directory, const ShownParts* shown, bool is_compressed,
                std::uint64_t mark = 0);

  static constexpr const char* list_name = "trajectory.pvd";
  static constexpr const char* frame_folder = "trajectory";
  static std::string name_frame(std::size_t number);

  void write(const Frame& frame) override;
  std::uint64_t mark() const override { return list_.body_size(); }
  /// Back to the mark before the last frame.
  void cut(std::uint64_t mark) override;
  void synchronize() override { list_.synchronize(); }

 private:
  std::filesystem::path directory_;
  const ShownParts* shown_;
  bool is_compressed_;
  std::filesystem::path last_;  ///< frame that was written
  GrowingFile list_;
};

}  // namespace tanor::report
