#pragma once

#include <span>
#include <vector>

#include "report/shown_parts.hpp"

namespace tanor::report {

/// Returns the forces of guides and supports on the shown points, 3m, N: K lambda without the pull of the rods, and at
/// a support the force that holds it. `positions` and `tensions` (N) are those of the shown points and rods;
/// `reactions` and `support_forces` are those of all points (3n).
std::vector<double> find_guide_forces(const ShownParts& shown, std::span<const double> positions,
                                      std::span<const double> tensions, std::span<const double> reactions,
                                      std::span<const double> support_forces);

}  // namespace tanor::report
