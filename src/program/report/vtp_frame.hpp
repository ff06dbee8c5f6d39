#pragma once

#include <filesystem>

#include "report/frame_file.hpp"
#include "report/output_file.hpp"
#include "report/shown_parts.hpp"

namespace tanor::report {

/// Writes one frame as VTK polydata (ParaView). Points have `velocity`, `acceleration` and `support` (1 for a support)
/// and, if points are held, `guide_force` (the force of guides and supports), with friction also `friction_force`. Rods
/// are lines with `tension`. Points without a rod form one vertex cell, so that they are visible too; its tension is
/// NaN. A rod with an offset (periodic image) ends at an image of its second point. Images follow the points in the
/// file and have the velocity and acceleration of their points. Guides are arrays of numbers in the field data, named
/// "guide <kind> <name>", and so is "gravity". `read_vtp` reads a frame back. Arrays are binary with all digits
/// ("appended raw"), each preceded by its number of bytes, or by those of its compressed blocks.
void write_vtp(const std::filesystem::path& path, const ShownParts& shown, const Frame& frame,
               bool is_compressed = false);

/// Writes `trajectory.pvd`, the list of frames, and `trajectory/frame_*.vtp`. A frame is complete before the list names
/// it.
class VtpTrajectory : public FrameFile {
 public:
  /// `shown` must outlive this object. `mark` is the number of bytes of the list, 0 for a new one.
  VtpTrajectory(const std::filesystem::path& directory, const ShownParts* shown, bool is_compressed,
                std::uint64_t mark = 0);

  static constexpr const char* list_name = "trajectory.pvd";
  static constexpr const char* frame_folder = "trajectory";
  static std::string name_frame(std::size_t number);

  /// A list of frames begins with its head, has an entry for each frame, and ends with its tail.
  static constexpr std::string_view
      list_head = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n",
      list_tail = "</Collection>\n</VTKFile>\n";
  static std::string list_frame(double time, const std::string& file);

  void write(const Frame& frame) override;
  std::uint64_t mark() const override { return list_.body_size(); }
  /// Cuts the list back to the mark before the last frame.
  void cut(std::uint64_t mark) override;
  void synchronize() override { list_.synchronize(); }

 private:
  std::filesystem::path directory_;
  const ShownParts* shown_;
  bool is_compressed_;
  std::filesystem::path last_;  ///< the frame that was written last
  GrowingFile list_;
};

}  // namespace tanor::report
