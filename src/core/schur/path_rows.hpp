#pragma once

#include <span>
#include <utility>
#include <vector>

#include "base/pack.hpp"
#include "schur/lane_transfers.hpp"
#include "schur/rod_rows.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Eight pieces of one path that follow one another, side by side in lanes.
struct PathPieces {
  std::size_t first_row, first_point, length;  ///< `length` rods a piece
  std::size_t first_slot;                      ///< in arrays of [length + 1] packs a block
  std::size_t first_separator;                 ///< of eight

  std::size_t num_points() const { return num_lanes * length; }  ///< but for the one behind the last piece
  /// Returns `count` things of each lane, if the first lane's begin at `first`.
  Sequences sequences(std::size_t first, std::size_t count, double sign = 1.0) const {
    Sequences result{.count = count, .sign = sign};
    for (std::size_t lane = 0; lane < num_lanes; ++lane) result.first[lane] = static_cast<Index>(first + lane * length);
    return result;
  }
};

/// The paths and rings of a system, cut into pieces and rods alone, with the numbers of their rods. Arrays by row have
/// the rows of the whole system; rods point along the path.
struct PathRows {
  /// A path with its pieces [first_pieces, end_pieces) and separators [first_separator, end_separator). The separators
  /// that `alone` lists are no piece's: [first_alone, end_alone).
  struct Cut {
    RodPath path;
    std::size_t first_pieces, end_pieces, first_separator, end_separator, first_alone, end_alone;
  };
  struct Alone {
    std::size_t row, separator;
  };

  std::span<const double> inverse_mass;  ///< [point]
  std::vector<Cut> paths;
  std::vector<PathPieces> pieces;
  std::vector<Alone> alone;
  std::size_t num_slots = 0, num_separators = 0, most_rods = 0;  ///< `most_rods` of a lane
  std::size_t num_rings = 0;

  std::vector<signed char> sign;                                            ///< [row] sign of its block
  std::vector<double> length;                                               ///< [row]
  Packs lengths;                                                            ///< [slot] those of pieces
  std::vector<Vec3> offset;                                                 ///< [row] empty if there are none
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths;  ///< lengths that depend on time, by row

  /// Takes the islands that are paths or rings out of `islands`.
  PathRows(const SchurProblem& problem, std::vector<Index>* islands);
  void read_offsets(std::span<const Vec3> offsets);
  void take_lengths();

  std::size_t block(std::size_t row) const { return block_numbers_.empty() ? first_block_ + row : block_numbers_[row]; }

  // ---- one rod ----

  Vec3 distance(const RodPath& path, std::size_t row, const double* r) const;
  Vec3 direction(const double* blocks, std::size_t row) const { return sign[row] * load(blocks, block(row)); }
  void write_direction(Vec3 u, std::size_t row, double* blocks) const { store(blocks, block(row), sign[row] * u); }
  /// Returns a derivative of the length of a row; 0 if it does not move.
  double length_change(std::size_t row, double MovingScalar::*part) const;

  // ---- the rods of pieces ----

  void read_directions(const PathPieces& of, const double* blocks, Pack3<>* u) const;
  void write_directions(const PathPieces& of, const Pack3<>* u, double* blocks) const;
  /// Reads the changes of lengths. Returns false if there are none.
  bool read_length_changes(const PathPieces& of, double MovingScalar::*part, Pack<>* to) const;

 private:
  void cut(const RodPath& path);
  void set_length(std::size_t row, double value);
  void find_signs(const RodRows& rods);

  std::size_t first_block_ = 0;
  std::vector<std::size_t> block_numbers_;  // [row]; empty if they follow the rows from the first block on
  std::vector<Index> places_;  // [slot][lane] block, ~block where it is turned; empty if blocks follow with one sign
  double common_sign_ = 0.0;   // of all blocks; 0 if some are turned and some are not
};

}  // namespace tanor::detail
