#pragma once

#include <span>
#include <vector>

#include "evaluate/constraints.hpp"
#include "schur/batch_kernels.hpp"
#include "schur/island_schedule.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// Islands of one topology in batches of eight. Lanes that are left over repeat the last island.
struct EqualIslands {
  struct Structure {
    const IslandTopology& topology;
    const IslandSchedule& schedule;
  };
  /// The rows, or blocks, of the rods. In most systems those of an island follow one another, and all islands have
  /// them in the same order.
  struct RodNumbers {
    bool follow = false;         // if true, `numbers` has the lowest ones, [batch][lane], and one batch more
    std::vector<Index> numbers;  // else [batch][rod][lane]; ~number if the rod is given the other way
    double sign = 1.0;           // if they follow: that of all, …
    SequencePlaces places;       // … unless they are in another order than the rods or have several signs

    const Index* of_batch(std::size_t batch, std::size_t num_rods) const {
      return numbers.data() + batch * (follow ? 1 : num_rods) * num_lanes;
    }
  };
  /// The numbers of one batch.
  struct Batch {
    const EqualIslands& of;
    std::size_t num_points, num_supports, num_rods;
    const Index *first_point, *supports, *rows, *blocks;
    const Pack<>* inverse_mass;
    const Pack3<>* offsets;                     // null if there are none
    const Pack<>* lengths;                      // the constant ones
    const MovingScalar* const* moving_lengths;  // null if there are none
    Pack<>* factor;

    Structure structure() const { return {of.topology, of.schedule}; }
  };

  explicit EqualIslands(const IslandTopology& islands) : topology(islands), schedule(islands) {}
  Batch batch(std::size_t number);
  void read_offsets(std::span<const Vec3> by_row);

  IslandTopology topology;
  IslandSchedule schedule;
  std::size_t num_islands = 0, num_batches = 0;
  std::vector<Index> first_point;  // [batch][lane], and one batch more; the moving points of an island follow it
  std::vector<Index> supports;     // [batch][support][lane]
  RodNumbers rows, blocks;
  Packs inverse_mass;            // [batch][place]: moving points, then supports; likewise one batch more
  std::vector<Pack3<>> offsets;  // [batch][rod]; empty if there are none
  struct ShiftedRod {            // a rod with an offset
    std::size_t place, lane, row;
    bool is_reversed;
  };
  std::vector<ShiftedRod> shifted_rods;
  Packs lengths;                                    // [batch][rod]
  std::vector<const MovingScalar*> moving_lengths;  // [batch][rod][lane], null if constant; empty if all are
  Packs factor;                                     // [batch][slot]
};

/// Takes islands of rods out of `islands` and groups them by their topologies. It takes islands of at most
/// `plan::most_rods_of_batch` rods if their topology has little fill and fills half of its lanes or more (long paths:
/// nearly all). If `eagerly` is true, it takes all islands of rods.
std::vector<EqualIslands> take_equal_islands(const Constraints& constraints, const Numbering& numbering,
                                             std::span<const double> inverse_mass, bool eagerly,
                                             std::vector<Index>* islands);

}  // namespace tanor::detail
