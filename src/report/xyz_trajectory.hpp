#pragma once

#include <optional>

#include "report/shown_parts.hpp"
#include "report/text_trajectory.hpp"
#include "scene/periodic_cell.hpp"

namespace tanor::report {

/// Extended XYZ (OVITO, ASE): a line a point with position and velocity, 10 significant digits (the .vtp frames have
/// all); `Lattice` and `pbc` where the sample is periodic along all three edges.
///
/// The species are "C" for points that move and "X" for supports: names that every reader of the format knows.
class XyzTrajectory : public TextTrajectory {
 public:
  /// `shown` must outlive it. `mark`: 0 for a new file.
  XyzTrajectory(const std::filesystem::path& path, const ShownParts* shown, const std::optional<scene::Cell>& cell,
                std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;

  const ShownParts* shown_;
  std::string lattice_;  ///< words of the second line, with a blank behind
};

}  // namespace tanor::report
