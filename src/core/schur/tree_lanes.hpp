#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/pack.hpp"
#include "base/parallel.hpp"
#include "schur/batch_kernels.hpp"
#include "schur/schur_solver.hpp"
#include "schur/tree_kernels.hpp"
#include "schur/tree_pieces.hpp"

namespace tanor::detail {

/// The pieces of trees in lanes: their rods with factor and right sides, and what pieces hand to one another.
class TreeLanes {
 public:
  /// Reads the rods. `inverse_mass` is [inner point].
  TreeLanes(TreePieces pieces, const RodRows& given, std::span<const double> inverse_mass, std::size_t num_moving,
            int threads);

  const TreePieces& pieces() const { return pieces_; }
  void read_offsets(std::span<const Vec3> by_row);
  /// Takes the lengths that move, l' and l''.
  void take_lengths();
  /// Returns how many of the threads have a workspace.
  std::size_t num_workspaces(const Parallel& parallel) const {
    return std::min(workspaces_.size(), static_cast<std::size_t>(parallel.threads()));
  }

  class Group;

  // Findings of each group [group], and lane by lane:
  double largest_inverse(std::size_t group) const { return found_.largest_inverse[group]; }  ///< S_aa/pivot
  /// Returns the largest |b|, or the largest violation.
  double right_side(std::size_t group, std::size_t lane) const { return found_.right_side[group * num_lanes + lane]; }
  double residual(std::size_t group, std::size_t lane) const { return found_.residual[group * num_lanes + lane]; }

 private:
  /// The arrays of one thread, [place] or [rod] of a group.
  struct Workspace {
    std::vector<Pack3<>> r, v, w, s, dw;
    std::vector<trees::Mobility> mobility;
    Packs rows;
  };
  struct Findings {
    std::vector<double> largest_inverse;       // [group]
    std::vector<double> right_side, residual;  // [group][lane]
  };
  /// Lengths of rods [rod], l' and l''; these are empty if no length moves.
  struct Lengths {
    Packs value, first, second;
  };
  /// The places of the blocks of a group.
  struct Blocks {
    std::array<Index, num_lanes> first;  ///< [lane] if they follow one another in each lane
    double sign = 0.0;                   ///< of all of them then; 0 if they do not follow
  };

  void read_rods(const RodRows& given, std::span<const double> inverse_mass);
  void find_blocks_that_follow();
  void prepare_workspaces(int threads);
  template <class Visit>
  void for_each_rod(const Visit& visit) const;

  TreePieces pieces_;
  Index num_moving_;
  std::vector<Index> block_;     // [rod][lane]; ~block if it is given the other way
  std::vector<Blocks> blocks_;   // [group]
  Packs inverse_mass_;           // [place]
  Packs inverse_masses_;         // [rod] those of both ends, summed
  std::vector<Pack3<>> offset_;  // [rod]; empty if there are none
  bool are_shifted_ = false;     // true if there are offsets of rods
  Lengths lengths_;              // of rods
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths_;  // by rod and lane
  std::vector<Pack3<>> u_;                                                   // [rod]
  std::vector<trees::RodFactor> factor_;                                     // [rod]
  Packs b_, z_;                                                              // [rod]
  std::vector<Pack3<>> kept_dw_;                                             // [place] of groups with joints
  std::vector<std::size_t> first_kept_;                                      // [group]
  std::vector<trees::Joint> joints_;                                         // [group]
  Findings found_;
  std::vector<Workspace> workspaces_;  // [thread]
};

/// One group in the lanes of a workspace.
class TreeLanes::Group {
 public:
  Group(TreeLanes* all, std::size_t group, std::size_t workspace);

  // ---- up ----
  /// Reads r, v and w0 of the points.
  trees::Motion read_motion(const FreeMotion& motion);
  void evaluate(const trees::Motion& motion);
  void eliminate();
  void evaluate_and_eliminate(const trees::Motion& motion);
  void substitute_up();

  // ---- down ----
  /// Substitutes down from the forces above the roots, and leaves dw in the lanes but for joints, which get the forces.
  void substitute_down();
  /// Computes points += dw instead. Joints get the `known` forces [place], too, unless they are null.
  void substitute_down(const Pack3<>* known, Pack3<>* points);
  /// Finds the residual. Joints have their dw once all pieces below are through.
  void find_residual();

  // ---- projections ----
  /// Evaluates the violation at `points`, positions or velocities.
  void evaluate_values(const double* r);
  void evaluate_rates(const double* r, const double* v);
  /// Finds dw = M^-1 K rows; a joint gets the rest from below.
  void find_reactions(const double* rows);
  void add_multipliers(double* sum);

  // ---- for series ----
  /// Sets s of joints to the answer of what hangs there, with that to the `force` [place] on them unless it is null.
  void answer_at_joints(const Pack3<>* force);
  void hand_over_answers() { in_.points.s[group_.num_rods].write(&own_joint().s); }
  /// Takes the numbers of the roots there at joints.
  void take_joints(Pack3<>* points);

  // ---- in and out ----
  /// Prefetches points and rows, or blocks, while something else is computed.
  void call_for(const double* points) const;
  void call_for_blocks(const double* blocks) const;
  void find_directions(const double* r);
  void read_directions(const double* blocks);
  void write_directions(double* blocks);
  void read_right_side(const double* b);
  void write_multipliers(double* x);
  /// Writes w := w0 + dw.
  void write_accelerations(Vec3 w0, double* w);
  /// Computes w += dw.
  void add_accelerations(double* w);
  /// Reads points in the place of dw; writes those that are the pieces' own.
  void read(const double* from);
  void write(const Pack3<>* from, double* to) const;

  // ---- the arrays ----
  const PieceGroup& plan() const { return group_; }
  struct Arrays {
    trees::Shape shape;
    trees::Points points;
    trees::Rods rods;
    Pack3<>* dw;
  };
  const Arrays& arrays() const { return in_; }
  /// Returns the parts of the distances [rod] that are not between the points; null if there are none.
  const Pack3<>* offsets() const;

 private:
  using Joint = trees::Joint;
  Joint& own_joint() { return all_.joints_[number_]; }
  std::span<const JointPlace> joints() const {
    return std::span(all_.pieces_.joints).subspan(group_.first_joint, group_.end_joint - group_.first_joint);
  }
  void take_mobilities();
  void take_force();
  void hand_over_forces(const Pack3<>* known);
  void accelerate();
  void hand_over_roots(const Pack3<>* points) { points[group_.num_rods].write(&own_joint().dw); }
  void note_right_side(const Largest& found);

  const Index* points() const { return all_.pieces_.point.data() + num_lanes * group_.first_place; }
  const Index* rows() const { return all_.pieces_.row.data() + num_lanes * group_.first_rod; }
  void read_points(const double* from, std::vector<Pack3<>>* to) const;
  void read_rows(const double* from, Pack<>* to) const;
  void write_rows(const Pack<>* from, double* to) const;

  TreeLanes& all_;
  std::size_t number_;
  const PieceGroup& group_;
  Workspace& work_;
  Arrays in_;
};

}  // namespace tanor::detail
