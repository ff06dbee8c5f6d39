#include "schur/group_transfers.hpp"

#include "base/vec3.hpp"

namespace tanor::detail {

// ---- points ----

void GroupTransfers::read_points(const double* from, Pack3<>* to) const {
  const std::size_t count = places_.points.count;
  if (count > 0) gather_sequences(from, places_.points, 3, &to->x);
  if (count < group_.num_places)
    gather<false>(from, points_ + count * num_lanes, group_.num_places - count, to + count);
}

void GroupTransfers::write_points(const Pack3<>* from, double* to) const {
  const std::size_t count = places_.own_points.count;
  if (count > 0) scatter_sequences(&from->x, places_.own_points, 3, to);
  if (count < group_.num_places)
    scatter<false>(from + count, points_ + count * num_lanes, group_.num_places - count, to);
}

void GroupTransfers::add_points(const Pack3<>* from, double* to) const {
  for (std::size_t lane = 0; lane < num_lanes; ++lane) {
    for (std::size_t k = 0; k < group_.num_places; ++k) {
      const Index point = points_[k * num_lanes + lane];
      if (point >= 0) store(to, point, load(to, point) + lane_of(from[k], lane));
    }
  }
}

// ---- rows ----

void GroupTransfers::read_rows(const double* from, Pack<>* to) const {
  if (places_.rows.count > 0) return gather_sequences(from, places_.rows, 1, to);
  gather_rows(from, rows_, group_.num_rods, to);
}

void GroupTransfers::write_rows(const Pack<>* from, double* to) const {
  if (next_ != nullptr) call_for(to, next_->rows, 1);
  if (places_.rows.count > 0) return scatter_sequences(from, places_.rows, 1, to);
  scatter_rows(from, rows_, group_.num_rods, to);
}

// ---- blocks ----

void GroupTransfers::read_blocks(const double* from, Pack3<>* to) const {
  if (places_.blocks.count > 0) return gather_sequences(from, places_.blocks, 3, &to->x);
  gather<true>(from, blocks_, group_.num_rods, to);
}

void GroupTransfers::write_blocks(const Pack3<>* from, double* to) const {
  if (places_.blocks.count > 0) return scatter_sequences(&from->x, places_.blocks, 3, to);
  scatter<true>(from, blocks_, group_.num_rods, to);
}

Vec3 GroupTransfers::block(const double* blocks, std::size_t rod, std::size_t lane) const {
  const Index own = blocks_[rod * num_lanes + lane];
  return own < 0 ? -load(blocks, ~own) : load(blocks, own);
}

}  // namespace tanor::detail
