#pragma once

#include <array>
#include <limits>
#include <span>
#include <vector>

#include <tanor/system.hpp>

#include "base/groups.hpp"
#include "base/parallel.hpp"
#include "evaluate/periodic_box.hpp"

namespace tanor::detail {

/// The bounding box of points, as the largest of each coordinate and of its negative, so that rooms join by maxima.
class PointRoom {
 public:
  void add(Vec3 r);
  std::span<double> ends() { return ends_; }
  /// Returns true if `num_points` spread evenly here had more than some hundred others each within `radius`.
  bool is_crowded(std::size_t num_points, double radius) const;

 private:
  std::array<double, 6> ends_{-unbounded, -unbounded, -unbounded, -unbounded, -unbounded, -unbounded};
  static constexpr double unbounded = std::numeric_limits<double>::max();
};

/// Lists, for each point, all others nearer than a cutoff, and some that are a little farther.
///
/// Cells as wide as cutoff + skin give the lists of all pairs nearer than that. The lists serve until a point has moved
/// by half the skin (Verlet). What a list holds beyond the cutoff depends on when it was made. Its order, by number,
/// does not, so a sum over the pairs within the cutoff has the same bits whatever came before.
class NeighbourLists {
 public:
  /// Points from `num_moving` on are supports; two of them are no pair, nor are those that `excluded` [point] names.
  NeighbourLists(double cutoff, double skin, const PeriodicBox& box, std::size_t num_moving, Groups<Index> excluded)
      : cutoff_(cutoff),
        skin_(skin),
        radius_(cutoff + skin),
        box_(box),
        num_moving_(num_moving),
        excluded_(std::move(excluded)) {}

  /// Makes the lists valid for these places. Returns false if a place or the square of a move is not finite.
  bool follow(const Parallel& parallel, const std::vector<Vec3>& places);

  double skin() const { return skin_; }
  /// Returns how often the lists were made.
  std::size_t version() const { return version_; }
  /// Returns true if the lists hold all pairs nearer than the cutoff as long as no point goes farther than `reach` from
  /// its place.
  bool cover(const Parallel& parallel, const std::vector<Vec3>& places, double reach) const;
  /// Makes the lists anew at these places, with another skin.
  void make(const Parallel& parallel, const std::vector<Vec3>& places, double skin);

  /// Calls body(point, its neighbours by number) for every point.
  template <class Body>
  void for_each_point(const Parallel& parallel, const Body& body) const {
    parallel.for_ranges(
        chunks_.size(),
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t c = begin; c < end; ++c) {
            const Chunk& chunk = chunks_[c];
            const Index* next = chunk.neighbours.data();
            for (std::size_t i = chunk.first; i < chunk.last; ++i) {
              body(i, std::span(next, num_neighbours_[i]));
              next += num_neighbours_[i];
            }
          }
        },
        1 + pairs_worth_a_thread * chunks_.size() / (num_pairs_ + 1));
  }

 private:
  /// Points next to each other, and their lists one behind the other. Each chunk is made by itself, so threads need not
  /// know of each other, and lists need not be counted before they are written.
  struct Chunk {
    std::size_t first = 0, last = 0;
    std::vector<Index> neighbours{};
  };
  /// Cells along one axis.
  struct Axis {
    bool is_periodic = false;
    double origin = 0.0, scale = 0.0;  // m, 1/m
    Index count = 1;

    Index cell(double x) const;
    /// Finds the runs [first, last) of the cells next to a cell and itself, each once; returns how many.
    int around(Index cell, std::array<std::array<Index, 2>, 3>* runs) const;
  };

  void lay_out_cells(const std::vector<Vec3>& places);
  void sort_into_cells(const std::vector<Vec3>& places);
  void make_lists(const Parallel& parallel, const std::vector<Vec3>& places);
  template <class Visit>
  void visit_neighbours(const std::vector<Vec3>& places, std::size_t i, const Visit& visit) const;
  bool is_pair(std::size_t i, Index j) const;

  /// Work of a tenth of a millisecond. Waking a thread and waiting for it takes as long where other programs run.
  static constexpr std::size_t points_worth_a_thread = 256, pairs_worth_a_thread = 32768;

  std::size_t num_pairs_ = 0;  // listed, each twice

  double cutoff_, skin_, radius_;  // m; the last one is the sum of the others
  std::size_t version_ = 0;
  PeriodicBox box_;
  std::size_t num_moving_;
  Groups<Index> excluded_;
  std::vector<Vec3> places_;  // [point] when the lists were made; empty before the first time
  std::vector<Chunk> chunks_;
  std::vector<std::size_t> num_neighbours_;  // [point]
  std::array<Axis, 3> axes_;
  Groups<Index> cells_;                        // points in each cell, by number
  std::vector<std::array<Index, 3>> cell_of_;  // [point]
  std::vector<Vec3> cell_places_;              // beside cells_.entries
  std::vector<Index> next_;                    // [cell], scratch
};

}  // namespace tanor::detail
