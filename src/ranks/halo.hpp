#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <tanor/ranks.hpp>

#include "base/vec3.hpp"
#include "evaluate/periodic_box.hpp"
#include "ranks/share.hpp"

namespace tanor {

/// Points of other ranks that come near this one's. Who they are, every rank finds by itself from the places of all
/// points, which it is told where the lists are made; these serve until a point has moved by half the skin (Verlet).
/// In between the places of near points alone are told, to the ranks that they are near to.
class Halo {
 public:
  /// `numbers`: of this rank's own points, in the whole system.
  Halo(Ranks& ranks, const PeriodicBox& box, double cutoff, std::span<const Index> numbers);

  /// Makes the lists for these places of own points. Collective.
  void make(std::span<const Vec3> own, double skin);
  /// The largest distance of an own point from where it was then, m, on this rank.
  double largest_move(std::span<const Vec3> own) const;
  double skin() const { return skin_; }
  /// Points of all ranks.
  std::size_t num_all() const { return share_.all(); }

  std::size_t size() const { return numbers_.size(); }
  /// The numbers of the points, in the whole system.
  const std::vector<Index>& numbers() const { return numbers_; }
  /// The halo's points that are near to own point i.
  std::span<const Index> near(std::size_t i) const {
    return std::span(near_).subspan(start_[i], start_[i + 1] - start_[i]);
  }

  /// The places of the halo's points [size()], of own points' on their ranks. Collective.
  void fetch(std::span<const Vec3> own, std::vector<Vec3>* places);

 private:
  struct Link {
    int rank;
    std::vector<Index> sent_points;    // own ones
    std::size_t first = 0, count = 0;  // of the halo
    std::vector<double> sent, received;
  };
  void connect(std::vector<Link> links);

  Ranks& ranks_;
  PeriodicBox box_;
  double cutoff_;
  std::vector<Index> own_numbers_;
  Share share_;  // of the points of all ranks
  // Of the last lists.
  double skin_ = 0.0;
  std::vector<Vec3> made_at_;  // [own point]
  std::vector<Index> numbers_;
  std::vector<std::size_t> start_;  // [own point + 1] in near_
  std::vector<Index> near_;
  std::vector<Link> links_;
  std::vector<Ranks::Message> messages_;
};

}  // namespace tanor
