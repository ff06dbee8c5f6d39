#pragma once

#include <filesystem>
#include <span>

#include "report/shown_parts.hpp"

namespace tanor::report {

/// The numbers of one .vtp file: rows of the shown points (3m) and the multipliers of all constraints (d).
struct VtpFrame {
  double time = 0.0;
  std::span<const double> positions, velocities, accelerations;
  std::span<const double> multipliers;
};

/// Writes one frame as VTK polydata (ParaView): points with `velocity` and `acceleration`, rods as lines with
/// `tension`, and points without a rod as one vertex cell, so that they are seen too (its tension is NaN: there is
/// none). A rod with an offset (periodic image) ends at an image of its second point, which follows the points in the
/// file with the velocity and acceleration of its own. Binary, all digits: "appended raw" arrays, each led by its
/// number of bytes.
void write_vtp(const std::filesystem::path& path, const ShownParts& shown, const VtpFrame& frame);

}  // namespace tanor::report
