#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "evaluate/constraints.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The rods of a system, row by row in the inner numbering. Solvers that go along rods read them.
struct RodRows {
  std::vector<std::array<Index, 2>> ends;                            ///< [row] inner points; {-1, -1} if it is no rod
  std::vector<std::size_t> block;                                    ///< [row]
  std::vector<double> constant_length;                               ///< [row]
  std::vector<Vec3> offset;                                          ///< [row] as in RodKernel; empty if there are none
  std::vector<std::pair<std::size_t, const MovingScalar*>> lengths;  ///< lengths that depend on time, by row

  RodRows(const Constraints& constraints, std::size_t num_rows)
      : ends(num_rows, {-1, -1}), block(num_rows), constant_length(num_rows) {
    const auto read = [&]<bool Timed, bool Shifted>(const Family<RodKernel<Timed, Shifted>>& rods) {
      if (Shifted && rods.size() > 0) offset.resize(num_rows);
      for (std::size_t k = 0; k < rods.size(); ++k) {
        const auto row = static_cast<std::size_t>(rods.rows[k]);
        ends[row] = rods.kernel.points[k];
        block[row] = static_cast<std::size_t>(rods.first_block) + k;
        if constexpr (Shifted) offset[row] = rods.kernel.offset[k];
        if constexpr (Timed) {
          lengths.emplace_back(row, &rods.kernel.moving_length[k]);
        } else {
          constant_length[row] = rods.kernel.length[k];
        }
      }
    };
    read(constraints.family<RodKernel<false, false>>());
    read(constraints.family<RodKernel<false, true>>());
    read(constraints.family<RodKernel<true, false>>());
    read(constraints.family<RodKernel<true, true>>());
    std::sort(lengths.begin(), lengths.end());
  }

  /// Returns null if the length of the row is constant.
  const MovingScalar* moving_length(std::size_t row) const {
    const auto length =
        std::lower_bound(lengths.begin(), lengths.end(), std::pair<std::size_t, const MovingScalar*>(row, nullptr));
    return length != lengths.end() && length->first == row ? length->second : nullptr;
  }
};

/// An island of rods that follow one another, point after point and row after row in the inner numbering. Of its rows
/// [first, end), row a joins the points a + shift and a + shift + 1, except that a support may stand at either end.
struct RodPath {
  std::size_t first, end;
  std::ptrdiff_t shift;
  Index left_support = -1, right_support = -1;
  bool is_ring = false;  ///< row `end` joins the last point and the first one

  /// Returns the first of its moving points; `end_point` is the one after the last.
  std::size_t first_point() const { return first + static_cast<std::size_t>(shift) + (left_support >= 0 ? 1 : 0); }
  std::size_t end_point() const { return end + static_cast<std::size_t>(shift) + (right_support >= 0 ? 0 : 1); }

  std::size_t num_rows() const { return end - first + (is_ring ? 1 : 0); }
  bool begins_at_support(std::size_t row) const { return row == first && left_support >= 0; }
  bool ends_at_support(std::size_t row) const { return row + 1 == end && right_support >= 0; }
  std::size_t left_point(std::size_t row) const {
    return begins_at_support(row) ? static_cast<std::size_t>(left_support) : row + static_cast<std::size_t>(shift);
  }
  std::size_t right_point(std::size_t row) const {
    if (ends_at_support(row)) return static_cast<std::size_t>(right_support);
    return (is_ring && row == end ? first : row + 1) + static_cast<std::size_t>(shift);
  }
  /// Returns the point behind so many rods.
  std::size_t point(std::size_t count) const { return count == 0 ? left_point(first) : right_point(first + count - 1); }
};

/// Returns the path or ring that an island is, or nothing. `ends` [row] are the inner points of the rods.
std::optional<RodPath> find_path(std::span<const std::array<Index, 2>> ends, const Numbering& numbering, Index island);

}  // namespace tanor::detail
