#pragma once

#include <optional>

#include "report/shown_parts.hpp"
#include "report/text_trajectory.hpp"

namespace tanor::report {

/// Writes extended XYZ (OVITO, ASE): a line for each point with position and velocity, 10 significant digits (the .vtp
/// frames have all). `Lattice` and `pbc` are given if the sample is periodic along all three edges.
///
/// The species are "C" for points that move and "X" for supports: names that every reader of the format knows.
class XyzTrajectory : public TextTrajectory {
 public:
  /// `shown` must outlive this object. `mark` is 0 for a new file.
  XyzTrajectory(const std::filesystem::path& path, const ShownParts* shown, const std::optional<Cell>& cell,
                std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;

  const ShownParts* shown_;
  std::string lattice_;  ///< words of the second line, followed by a blank
};

}  // namespace tanor::report
