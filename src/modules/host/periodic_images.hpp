#pragma once

#include <array>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "evaluate/constraints.hpp"
#include "system/numbering.hpp"

namespace tanor::detail {

/// The lattice of a periodic cell: the vectors H n, n being three whole numbers.
class Lattice {
 public:
  /// Throws InputError if the edges do not span space.
  explicit Lattice(const PeriodicCell& cell);

  /// Returns H^-1 r.
  Vec3 fraction(Vec3 r) const { return {dot(reciprocal_[0], r), dot(reciprocal_[1], r), dot(reciprocal_[2], r)}; }
  /// Returns the n nearest to a fraction, with 0 along edges that do not repeat.
  Vec3 round(Vec3 fraction) const;
  Vec3 vector(Vec3 n) const { return n.x * edge_[0] + n.y * edge_[1] + n.z * edge_[2]; }
  /// Returns the smallest distance between opposite faces along edges that repeat, infinite if none does.
  double smallest_height() const;

 private:
  std::array<Vec3, 3> edge_, reciprocal_;
  std::array<bool, 3> repeats_;
};

/// The images of its points that a constraint means. Connected points are followed along a tree: each point is taken at
/// the image that its constraint with its parent means. The points of a rod outside the tree may be a lattice vector
/// apart, in a net that closes round the cell. The rod keeps that vector as its offset.
class PeriodicImages {
 public:
  /// Throws InputError if the constraints do not fit a cell.
  PeriodicImages(const System& system, const Periodicity& given);

  const PeriodicCell& cell() const { return cell_; }
  const Lattice& lattice() const { return lattice_; }
  void set_cell(const PeriodicCell& cell);
  /// True if rods join nearest images; if false, the images were given.
  bool are_nearest() const { return counts_.empty(); }
  /// True if some rod closes a way round the cell.
  bool close_ways() const { return closes_; }
  /// Sets the positions to those images. Called before `use`, as the next one.
  void set_positions(System* system) const;
  /// Sets the offsets of rods in this cell.
  void set_offsets(System* system) const;

  /// Sets the inner order that arrays have from here on. `system` is the one whose positions were set.
  void use(const System& system, const Numbering& numbering);
  /// Returns the offsets of the rods that close ways, in the cell of `lattice`, or by how much they are larger than in
  /// that of `before`. They stand until the next such call.
  std::span<const Constraints::RowOffset> find_offsets(const Lattice& lattice, const Lattice* before = nullptr);
  /// Sets x [3n] to the host's positions at those images, in the cell of `lattice`.
  void unwrap(const Parallel& parallel, const Lattice& lattice, const double* host, double* x) const;
  /// Moves r [3n], the host's positions in this cell, to the images nearest to those of x [3n] in the cell `before`.
  void follow(const Parallel& parallel, const Lattice& before, const double* x, double* r) const;

 private:
  struct Branch {
    Index point, parent;  // parent is -1 for a root
  };
  void grow_tree(const System& system, std::span<const std::array<int, 3>> images);
  void count_edges_apart(const System& system, std::span<const std::array<int, 3>> images);

  PeriodicCell cell_;
  Lattice lattice_;
  std::vector<Branch> branches_;          // parents before children
  std::vector<std::size_t> tree_start_;   // [tree] its start in `branches_`
  std::vector<Vec3> counts_;              // [point] n of its image, if images are given
  std::vector<std::vector<Vec3>> apart_;  // [group of rods][rod] n of its offset; empty if none
  struct ClosingRod {
    std::size_t row;  // inner
    Vec3 apart;       // n of its offset
  };
  std::vector<ClosingRod> closing_rods_;  // ascending
  std::vector<Constraints::RowOffset> offsets_;
  bool closes_ = false;
};

}  // namespace tanor::detail
