#pragma once

#include <optional>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "evaluate/family.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// Paths of rods laid over SIMD lanes. Long paths are cut: lane s has the s-th piece of one path, and the last rod of
/// each lane is a separator between it and the next. Short paths have a lane of their own.
///
/// Rod i of a lane joins its points i and i + 1. In pieces of one path the last point of a lane is the first of the
/// next. Lanes that are shorter than the others end with rods that are not there.
struct RodLanes {
  static constexpr std::size_t most = 8, few = 2;

  std::size_t width = most;   ///< lanes: `most`, or `few` where no more paths are left
  std::size_t length = 0;     ///< rods a lane
  bool is_cut = false;        ///< the lanes are pieces of one path
  std::vector<Index> points;  ///< [length + 1][width] inner; -1: not there. Of pieces, a shared point is in both
  std::vector<Index> rows;    ///< [length][width] inner row; -1: not there
  std::vector<char> flipped;  ///< [length][width] the rod runs against the path
};

/// Lays all rods of a system over lanes. Returns nothing where an island is no path, or has constraints that are no
/// rods. Fixed points end a path. `incidences` are those of K.
std::optional<std::vector<RodLanes>> lay_rods(const System& system, const Numbering& numbering,
                                              std::span<const Incidence> incidences);

}  // namespace tanor
