#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "base/vec3.hpp"
#include "dynamics/decisions.hpp"
#include "evaluate/periodic_box.hpp"
#include "ranks/point_exchange.hpp"

namespace tanor::detail {

/// Points of other ranks that come near this rank's. Every rank finds them by itself from the places of all points,
/// which are exchanged when the lists are made. The lists serve until a point has moved by half the skin (Verlet). In
/// between only near points are exchanged, with the ranks that they are near to.
class Halo {
 public:
  /// `numbers` are those of this rank's own points in the whole system.
  Halo(Ranks& ranks, const PeriodicBox& box, double cutoff, std::span<const Index> numbers);

  /// Makes the lists for these places of own points. Collective.
  void make(std::span<const Vec3> own, double skin);
  /// Returns the largest distance of an own point from its place when the lists were made, m, on this rank.
  double largest_move(std::span<const Vec3> own) const;
  double skin() const { return skin_; }
  /// Returns the number of points of all ranks.
  std::size_t num_all() const { return share_.all(); }

  std::size_t size() const { return numbers_.size(); }
  /// Returns the numbers of the halo's points in the whole system.
  const std::vector<Index>& numbers() const { return numbers_; }
  /// Returns the halo's points that are near to own point i.
  std::span<const Index> near(std::size_t i) const {
    return std::span(near_).subspan(start_[i], start_[i + 1] - start_[i]);
  }

  /// Fetches the places of the halo's points [size()], from those of own points on their ranks. Collective.
  void fetch(std::span<const Vec3> own, std::vector<Vec3>* places);

 private:
  Ranks& ranks_;
  PeriodicBox box_;
  double cutoff_;
  std::vector<Index> own_numbers_;
  Share share_;  // share of the points of all ranks
  // State of the last lists.
  double skin_ = 0.0;
  std::vector<Vec3> made_at_;  // [own point]
  std::vector<Index> numbers_;
  std::vector<std::size_t> start_;  // [own point + 1] in near_
  std::vector<Index> near_;
  std::optional<PointExchange> exchange_;
};

}  // namespace tanor::detail
