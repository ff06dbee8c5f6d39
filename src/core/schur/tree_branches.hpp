#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "base/pack.hpp"
#include "base/parallel.hpp"
#include "schur/equal_branches.hpp"
#include "schur/tree_kernels.hpp"
#include "schur/tree_points.hpp"

namespace tanor::detail {

/// The equal branches of trees, eight side by side in the lanes of a vector: their rods, with factor and right sides.
class TreeBranches {
 public:
  /// Reads the rods of the branches. `inverse_mass` is [inner point].
  TreeBranches(EqualBranches plan, const RodRows& given, std::span<const double> inverse_mass, int threads);

  const EqualBranches& plan() const { return plan_; }
  std::size_t num_rods() const { return plan_.num_rods() * num_lanes; }
  void read_offsets(std::span<const Vec3> by_row);
  bool has_moving_lengths() const { return !moving_lengths_.empty(); }

  class Lanes;
  /// Returns how many of the threads have a workspace.
  std::size_t num_workspaces(const Parallel& parallel) const {
    return std::min(workspaces_.size(), static_cast<std::size_t>(parallel.threads()));
  }

  // Findings of the lanes in each branch since `forget_findings`:
  void forget_findings();
  /// Returns the largest |b|, or the largest violation.
  double right_side(std::size_t batch, std::size_t lane) const { return right_side_[batch * num_lanes + lane]; }
  double residual(std::size_t batch, std::size_t lane) const { return residual_[batch * num_lanes + lane]; }
  trees::LargestInverse largest_inverse() const;

 private:
  /// The arrays of one thread, [point of a branch] or [rod of a branch].
  struct Workspace {
    std::vector<Pack3<>> r, v, w, s, dw, u;
    std::vector<trees::Mobility<Pack3<>>> mobility;
    Packs rows, length_second;
    trees::LargestInverse largest_inverse;
  };

  void read_rods(const RodRows& given, std::span<const double> inverse_mass);
  void prepare_workspaces(int threads);

  EqualBranches plan_;
  std::vector<Index> blocks_;                        // [rod][lane]; ~block if the rod is given the other way
  std::vector<Pack3<>> offsets_;                     // [rod]; empty if there are none
  Packs length_;                                     // [rod]
  std::vector<const MovingScalar*> moving_lengths_;  // [rod][lane], null if constant; empty if all are
  Packs inverse_mass_;                               // [point]
  std::vector<trees::BranchRod> rods_;               // [rod]
  std::vector<trees::BranchRow> rows_;               // [rod]
  std::vector<double> right_side_, residual_;        // [batch][lane] the largest ones
  std::vector<Workspace> workspaces_;                // [thread]
};

}  // namespace tanor::detail
