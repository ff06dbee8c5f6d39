#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

#include "base/pack.hpp"
#include "base/vec3.hpp"
#include "schur/path_lanes.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Moves points between an array [3n] and lanes. Where a lane's points follow one another in the array, as those
/// of a path mostly do, they move as whole vectors, eight points of eight lanes at a time.
template <std::size_t width>
class LanePoints {
 public:
  using Vector = Pack3<width>;

  /// Takes the points [points a lane][width] as RodLanes has them, -1 where there is none.
  explicit LanePoints(std::vector<Index> points) : points_(std::move(points)) {
    const std::size_t length = points_.size() / width;
    if (width != eight || length < eight) return;
    for (std::size_t first = 0; first < length; first += eight) {
      Block block{std::min(first, length - eight), {}};
      for (std::size_t lane = 0; lane < width; ++lane) {
        const auto point = [&](std::size_t i) { return points_[(block.first + i) * width + lane]; };
        bool follows = point(0) >= 0;
        for (std::size_t i = 1; i < eight; ++i) follows = follows && point(i) == point(0) + static_cast<Index>(i);
        block.start[lane] = follows ? point(0) : -1;
      }
      blocks_.push_back(block);
    }
  }

  /// Stores the eight points from `first` on if they are a block that reaches no end. The caller goes backwards along
  /// the lanes. `at(i)` returns point i of all lanes.
  template <class At>
  [[gnu::always_inline]] void store_inner(std::size_t first, double* to, const At& at) const {
    if constexpr (width == eight) {
      const std::size_t block = first / eight;
      if (first % eight == 0 && block > 0 && block + 1 < blocks_.size()) store_block(blocks_[block], to, at);
    }
  }
  /// Stores the points that store_inner leaves out.
  template <class At>
  [[gnu::always_inline]] void store_ends(double* to, const At& at) const {
    if constexpr (width == eight) {
      if (!blocks_.empty()) store_block(blocks_.front(), to, at);
      if (blocks_.size() > 1) store_block(blocks_.back(), to, at);
    }
    if (!blocks_.empty()) return;
    const Index* point = points_.data();
    for (std::size_t i = 0; i < points_.size() / width; ++i) {
      const Vector& r = at(i);
      for (std::size_t lane = 0; lane < width; ++lane, ++point) {
        if (*point >= 0) store(to, *point, {r.x[lane], r.y[lane], r.z[lane]});
      }
    }
  }

  /// Loads all points. A point that is not there becomes 0.
  template <class At>
  [[gnu::always_inline]] void load_from(const double* from, const At& at) const {
    if constexpr (width == eight) {
      for (const Block& block : blocks_) load_block(block, from, at);
    }
    if (!blocks_.empty()) return;
    const Index* point = points_.data();
    for (std::size_t i = 0; i < points_.size() / width; ++i) {
      Vector& r = at(i);
      for (std::size_t lane = 0; lane < width; ++lane, ++point) {
        const Vec3 place = *point >= 0 ? load(from, *point) : Vec3{};
        r.x[lane] = place.x;
        r.y[lane] = place.y;
        r.z[lane] = place.z;
      }
    }
  }

 private:
  static constexpr std::size_t eight = 8, numbers = 3 * eight;
  using Numbers = std::array<double, numbers>;  // numbers of eight points of a lane
  struct Block {
    std::size_t first;                 // first point in a lane
    std::array<Index, eight> start{};  // [lane] first point in the array if its points are consecutive, else -1
  };

  Index point(const Block& block, std::size_t i, std::size_t lane) const {
    return points_[(block.first + i) * width + lane];
  }

  // The x, y, z of eight points are 24 lanes. Each eight of these, transposed, are eight consecutive numbers of each
  // lane.
  template <class At>
  [[gnu::always_inline]] void store_block(const Block& block, double* to, const At& at) const {
    std::array<Numbers, eight> apart;  // NOLINT: filled where needed
    for (std::size_t part = 0; part < 3; ++part) {
      Pack<> rows[eight];
      for (std::size_t k = 0; k < eight; ++k) {
        const Vector& r = at(block.first + (eight * part + k) / 3);
        rows[k] = (eight * part + k) % 3 == 0 ? r.x : (eight * part + k) % 3 == 1 ? r.y : r.z;
      }
      transpose(rows);
      for (std::size_t lane = 0; lane < eight; ++lane) {
        double* const begin = block.start[lane] >= 0 ? to + 3 * block.start[lane] : apart[lane].data();
        pack_to(begin + eight * part) = rows[lane];
      }
    }
    for (std::size_t lane = 0; lane < eight; ++lane) {
      for (std::size_t i = 0; block.start[lane] < 0 && i < eight; ++i) {
        if (point(block, i, lane) >= 0) store(to, point(block, i, lane), load(apart[lane].data(), i));
      }
    }
  }

  template <class At>
  [[gnu::always_inline]] void load_block(const Block& block, const double* from, const At& at) const {
    std::array<Numbers, eight> apart;  // NOLINT: filled where needed
    for (std::size_t lane = 0; lane < eight; ++lane) {
      for (std::size_t i = 0; block.start[lane] < 0 && i < eight; ++i)
        store(apart[lane].data(), i, point(block, i, lane) >= 0 ? load(from, point(block, i, lane)) : Vec3{});
    }
    for (std::size_t part = 0; part < 3; ++part) {
      Pack<> rows[eight];
      for (std::size_t lane = 0; lane < eight; ++lane) {
        const double* const begin = block.start[lane] >= 0 ? from + 3 * block.start[lane] : apart[lane].data();
        rows[lane] = pack_at(begin + eight * part);
      }
      transpose(rows);
      for (std::size_t k = 0; k < eight; ++k) {
        Vector& r = at(block.first + (eight * part + k) / 3);
        ((eight * part + k) % 3 == 0 ? r.x : (eight * part + k) % 3 == 1 ? r.y : r.z) = rows[k];
      }
    }
  }

  std::vector<Index> points_;
  std::vector<Block> blocks_;  // empty if points are moved one by one
};

}  // namespace tanor::detail
