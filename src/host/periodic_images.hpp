#pragma once

#include <array>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/parallel.hpp"
#include "base/vec3.hpp"
#include "system/numbering.hpp"

namespace tanor {

/// The vectors H n, n three whole numbers, along which a cell repeats itself.
class Lattice {
 public:
  /// Throws InputError where the edges span no space.
  explicit Lattice(const PeriodicCell& cell);

  /// H^-1 r
  Vec3 fraction(Vec3 r) const { return {dot(reciprocal_[0], r), dot(reciprocal_[1], r), dot(reciprocal_[2], r)}; }
  /// The nearest n to a fraction; 0 where the cell does not repeat itself.
  Vec3 round(Vec3 fraction) const;
  Vec3 vector(Vec3 n) const { return n.x * edge_[0] + n.y * edge_[1] + n.z * edge_[2]; }
  /// Of those along which it repeats itself, the smallest distance between opposite faces; infinite: it never does.
  double smallest_height() const;

 private:
  std::array<Vec3, 3> edge_, reciprocal_;
  std::array<bool, 3> repeats_;
};

/// Which images of its points a constraint means. What constraints join is followed along a tree: each point is taken
/// at the image that its constraint with its parent means. A rod that is not in the tree may find its points a lattice
/// vector apart: a net that closes round the cell. It keeps that as its offset.
class PeriodicImages {
 public:
  /// Throws InputError where the constraints do not go with a cell.
  PeriodicImages(const System& system, const Periodicity& given);

  const PeriodicCell& cell() const { return cell_; }
  const Lattice& lattice() const { return lattice_; }
  void set_cell(const PeriodicCell& cell);
  /// Rods join nearest images; else those that were given.
  bool are_nearest() const { return counts_.empty(); }
  /// Some rod closes a way round the cell.
  bool close_ways() const { return closes_; }
  /// Positions := at those images, and the offsets of rods in this cell. Before `use`.
  void prepare(System* system) const;
  void set_offsets(System* system) const;

  /// From here on arrays are in this inner order.
  void use(const Numbering& numbering);
  /// x [3n] := the host's positions at those images, in the cell of `lattice`.
  void unwrap(const Parallel& parallel, const Lattice& lattice, const double* host, double* x) const;
  /// r [3n], the host's positions in this cell, to the images that are nearest to those of x [3n] in the cell `before`.
  void follow(const Parallel& parallel, const Lattice& before, const double* x, double* r) const;

 private:
  struct Branch {
    Index point, parent;  // -1: a root
  };
  void grow_tree(const System& system, std::span<const std::array<int, 3>> images);
  void find_offsets(const System& system, std::span<const std::array<int, 3>> images);

  PeriodicCell cell_;
  Lattice lattice_;
  std::vector<Branch> branches_;          // parents before children
  std::vector<std::size_t> tree_start_;   // in `branches_`, of each tree
  std::vector<Vec3> counts_;              // [point] n of its image, where images are given
  std::vector<std::vector<Vec3>> apart_;  // [group of rods][rod] n of its offset; empty: none
  bool closes_ = false;
};

}  // namespace tanor
