#pragma once

#include "schur/equal_islands.hpp"

/// \file Moves the numbers of a batch between arrays of the system and lanes.
namespace tanor::detail::batches {

using Batch = EqualIslands::Batch;

inline Pack<>* numbers_of(Pack3<>* points) {
  return &points->x;
}
inline const Pack<>* numbers_of(const Pack3<>* points) {
  return &points->x;
}

inline void read_points(const Batch& batch, const double* from, Pack3<>* to) {
  gather_sequences(from, batch.first_point, 3, 3 * batch.num_points, 1.0, numbers_of(to));
}
inline void read_supports(const Batch& batch, const double* from, Pack3<>* to) {
  gather_points(from, batch.supports, batch.num_supports, to + batch.num_points);
}
inline void write_points(const Batch& batch, const Pack3<>* from, double* to) {
  scatter_sequences(numbers_of(from), batch.first_point, 3, 3 * batch.num_points, 1.0, to);
}
inline void read_blocks(const Batch& batch, const double* from, Pack3<>* u) {
  const EqualIslands::RodNumbers& blocks = batch.of.blocks;
  if (!blocks.follow) return gather_blocks(from, batch.blocks, batch.num_rods, u);
  if (!blocks.places.place.empty()) return gather_sequences(from, batch.blocks, 3, blocks.places, numbers_of(u));
  gather_sequences(from, batch.blocks, 3, 3 * batch.num_rods, blocks.sign, numbers_of(u));
}
inline void write_blocks(const Batch& batch, const Pack3<>* u, double* to) {
  const EqualIslands::RodNumbers& blocks = batch.of.blocks;
  if (!blocks.follow) return scatter_blocks(u, batch.blocks, batch.num_rods, to);
  if (!blocks.places.place.empty()) return scatter_sequences(numbers_of(u), batch.blocks, 3, blocks.places, to);
  scatter_sequences(numbers_of(u), batch.blocks, 3, 3 * batch.num_rods, blocks.sign, to);
}
inline void read_rows(const Batch& batch, const double* from, Pack<>* to) {
  if (!batch.of.rows.follow) return gather_rows(from, batch.rows, batch.num_rods, to);
  gather_sequences(from, batch.rows, 1, batch.num_rods, 1.0, to);
}
inline void write_rows(const Batch& batch, const Pack<>* from, double* to) {
  if (!batch.of.rows.follow) return scatter_rows(from, batch.rows, batch.num_rods, to);
  scatter_sequences(from, batch.rows, 1, batch.num_rods, 1.0, to);
}

}  // namespace tanor::detail::batches
