#pragma once

#include <span>
#include <vector>

#include "base/pack.hpp"
#include "schur/needed_terms.hpp"
#include "schur/rod_rows.hpp"

namespace tanor::detail {

/// The motion of short paths of rods of fixed length as a power series, with the recurrences of GroupSeries, one path
/// after the other. The lanes have the x, y, z of a rod and its multiplier: short paths leave lanes of groups empty,
/// and are over before a group has begun.
class ShortPathSeries final : public IslandSeries {
 public:
  /// Takes the islands that are paths of fewer than `plan::fewest_rods_of_cut_path` rods out of `islands`. Keeps a
  /// reference to `inverse_mass` [inner point].
  ShortPathSeries(const RodRows& rods, const Numbering& numbering, std::span<const double> inverse_mass,
                  std::vector<Index>* islands);

  std::size_t num_parts() const override { return paths_.size(); }
  double expand(const Parallel& parallel, const LaneExpansion& expansion) override;

 private:
  struct Rod {
    Four u;                                   // a_0
    double inverse_pivot, l, half_square, x;  // S = L D L': 1/D, and L of the next row; the unknown
  };
  struct Point {
    Four r;                                         // of the current order
    double inverse_mass, of_position, of_velocity;  // weights of terms, see TermCounter
    Index number;                                   // inner
  };
  struct Path {
    RodPath rows;
    std::vector<Vec3> offsets;  // [rod] part of a_0; empty if there are none
  };
  /// The arrays of a thread.
  struct Room {
    std::vector<Rod> rods;      // [rod]
    std::vector<Point> points;  // [rod + 1]
    Packs series;               // [rod][order] Four of a_k and mu_k
    double longest;             // see FoundTerms
  };
  struct OnePath;

  std::vector<Path> paths_;
  std::span<const double> inverse_mass_;
  std::size_t num_points_ = 0, most_rods_ = 0;
  std::vector<Room> rooms_;  // [thread]
};

}  // namespace tanor::detail
