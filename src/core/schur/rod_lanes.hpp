#pragma once

#include <vector>

#include <tanor/system.hpp>

#include "schur/rod_rows.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Paths of rods laid over SIMD lanes. Long paths are cut: lane s has the s-th piece of one path, and the last rod of
/// each lane is a separator between it and the next. Short paths have a lane of their own.
///
/// Rod i of a lane joins its points i and i + 1. In pieces of one path the last point of a lane is the first of the
/// next. Lanes that are shorter than the others end with rods that are not there.
struct RodLanes {
  static constexpr std::size_t most = 8, few = 2;

  std::size_t width = most;   ///< number of lanes: `most`, or `few` if no more paths are left
  std::size_t length = 0;     ///< rods a lane
  bool is_cut = false;        ///< true if the lanes are pieces of one path
  std::vector<Index> points;  ///< [length + 1][width] inner, or -1; pieces have their shared point twice
  std::vector<Index> rows;    ///< [length][width] inner row, or -1
  std::vector<char> flipped;  ///< [length][width] 1 if the rod runs against the path
};

/// Lays the islands that are paths over lanes, and takes them out of `islands`. Fixed points end a path.
std::vector<RodLanes> lay_rods(const RodRows& rods, const Numbering& numbering, std::vector<Index>* islands);

}  // namespace tanor::detail
