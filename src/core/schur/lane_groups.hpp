#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/pack.hpp"
#include "base/parallel.hpp"
#include "schur/lane_kernels.hpp"
#include "schur/lane_plan.hpp"
#include "schur/lane_transfers.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Says what groups keep in lanes while a call is in other ones. In `Repeated` passes these are rods and points, which
/// all but paths keep in any case, directions and sums; in a `Single` one paths keep no more than b and what was found.
enum class Pass { Single, Repeated };

/// Groups in lanes (LaneGroup): their rods with the factor, and what pieces hand to one another.
class LaneGroups {
 public:
  /// Reads the rods. `inverse_mass` is [inner point].
  LaneGroups(LanePlan plan, const RodRows& given, std::span<const double> inverse_mass, std::size_t num_moving,
             int threads);

  const LanePlan& plan() const { return plan_; }
  void read_offsets(std::span<const Vec3> by_row);
  bool goes_through_memory(Pass pass) const { return pass == Pass::Single && plan_.is_of_paths(); }
  /// Makes room for what is kept in lanes, at the first pass of a kind.
  void hold(Pass pass);
  /// Takes the lengths that move, l' and l''.
  void take_lengths();
  /// Returns how many threads are worth their while on so many rods in lanes.
  std::size_t num_shares(std::size_t num_slots, const Parallel& parallel) const;

  /// Returns the separators of a path.
  lanes::Separators separators(std::size_t path) {
    const auto [first, end, is_ring] = plan_.paths[path];
    return {borders_.data(), std::span(plan_.separators).subspan(first, end - first), is_ring};
  }

  class Group;

  /// The numbers of a group in the arrays of the system.
  struct Lists {
    LaneList<Listed::Points> points;  ///< ~point if it is not to be written
    LaneList<Listed::Blocks> blocks;
    LaneList<Listed::Rows> rows;
  };

  /// The arrays of a thread.
  struct Workspace {
    // of one group, [place]
    std::vector<Pack3<>> r, v, w, s, dw;
    std::vector<lanes::Mobility> mobility;
    // of a grove, [rod], [place] and [group], or of the part that is kept, see Pass
    std::vector<Pack3<>> u, directions, points;
    Packs b, z, sum, right_side, residual;
    LanePlan::Extent largest;  // of its groves
    // found in all groves, in lanes and island by island
    lanes::Findings found;
    Elimination of_islands;
    Projection projection;
  };
  std::span<Workspace> workspaces() { return workspaces_; }

 private:
  void read_rods(const RodRows& given);
  void read_masses(std::span<const double> inverse_mass);
  void prepare_workspaces(int threads);
  template <class Visit>
  void for_each_rod(const Visit& visit) const;

  LanePlan plan_;
  Index num_moving_;
  std::vector<Index> block_;                     // [rod][lane]; ~block if it is turned
  std::vector<Lists> lists_;                     // [group]
  Packs inverse_mass_;                           // [place]
  std::vector<Pack3<>> offset_;                  // [rod] of groups that have some
  bool are_shifted_ = false;                     // true if there are offsets of rods
  Packs length_, length_first_, length_second_;  // [rod]; l' and l'' are empty if no length moves
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths_;  // by rod and lane
  std::vector<Pack3<>> u_;                                                   // [rod] of trees
  Packs factor_;
  std::vector<lanes::Joint> joints_;    // [group] of pieces of trees
  std::vector<lanes::Border> borders_;  // [group] of pieces of paths
  std::vector<Workspace> workspaces_;   // [thread]
};

/// One group in the lanes of the workspaces of a thread and of its grove.
class LaneGroups::Group {
 public:
  Group(LaneGroups* all, Pass pass, std::size_t group, std::size_t first_group, std::size_t of_grove,
        std::size_t of_thread);

  // ---- up ----
  /// Reads r, v and w0 of the points. The next group will write its part of `blocks`.
  lanes::Motion read_motion(const FreeMotion& motion, const double* blocks);
  void evaluate(const lanes::Motion& motion) { lanes::evaluate(in_, motion, false); }
  /// Factorizes S. The pivot of a rod of a tree is d = u'(W_c + W_p) u, and W_p -= h h'/d.
  void eliminate();
  void evaluate_and_eliminate(const lanes::Motion& motion);
  void substitute_up();

  /// Does all of a solve of a group that stands alone.
  void solve(const lanes::Motion& motion, const Vec3* uniform, FactorUse use, double* w);

  // ---- down ----
  /// Finds lambda, unless it is known, and the forces of the rods, which joints hand down with the `known` ones [place]
  /// unless these are null, and computes points += dw [place] unless these are null.
  void substitute_down(Pack3<>* points = nullptr, const Pack3<>* known = nullptr, bool lambda_is_known = false);
  /// Finds lambda, w := w0 + dw, and the residual unless there are joints. w0 is in w unless it is `uniform`.
  void substitute_down(const double* blocks, const Vec3* uniform, double* w);
  /// Finds the residual, the largest |K'dw + b|, once all pieces below joints are through.
  void find_residual();

  /// Reads u of separators, and their multipliers unless `rows` are null.
  void read_separators(const double* blocks, const double* rows = nullptr);

  // ---- projections ----
  /// Evaluates xi or K'v + xi_t in b's place, and the violation of `points`, positions or velocities.
  void evaluate_values();
  void evaluate_rates();
  /// Finds lambda, unless it is known, and computes points += dw in memory. Separators have theirs.
  void move(const double* blocks, bool lambda_is_known, double* points);

  // ---- what pieces hand to one another ----
  /// Sets s of joints to the answer of what hangs there, with that to the `force` [place] on them unless it is null.
  void answer_at_joints(const Pack3<>* force);
  void hand_over_answers() {
    if (may_hang()) in_.s[group_.num_rods].write(&own_joint().s);
  }
  /// Takes the numbers of the roots there at joints, and behind pieces of a path those of the next one's first point.
  void take_joints(Pack3<>* points);
  /// Hands over what these pieces of a path add to the points before and behind them; nothing if `points` is null.
  void hand_over_ends(const Pack3<>* points);

  // ---- in and out ----
  const Lists& lists() const { return lists_; }
  void write_rows(const Pack<>* from, double* to) const;
  /// Prefetches what the next group will read or write, while something else is computed.
  void call_for_points(const double* points) const {
    if (next_ != nullptr) next_->points.call_for(points);
  }
  void call_for_blocks(const double* blocks) const {
    if (next_ != nullptr) next_->blocks.call_for(blocks);
  }
  void find_directions(const double* r, Pack3<>* u);
  void read_directions(const double* blocks);

  // ---- the arrays ----
  const LaneGroup& plan() const { return group_; }
  using Arrays = lanes::Arrays;
  const Arrays& arrays() const { return in_; }
  Pack3<>* scratch() { return work_.s.data(); }  ///< [place]

 private:
  using Joint = lanes::Joint;
  Joint& own_joint() { return all_.joints_[number_]; }
  std::span<const JointPlace> joints() const {
    return std::span(all_.plan_.joints).subspan(group_.first_joint, group_.end_joint - group_.first_joint);
  }
  bool is_path() const { return all_.plan_.is_of_paths(); }
  bool is_tree() const { return all_.plan_.is_of_trees(); }
  bool may_hang() const { return is_tree() && !group_.stands_alone; }
  void take_mobilities();
  lanes::Upcoming upcoming(std::array<const double*, 3> arrays) const;
  void hand_over_roots(const Pack3<>* points);
  void pull_joints(const Pack3<>* known);
  void add_points(const Pack3<>* from, double* to) const;

  LaneGroups& all_;
  std::size_t number_;
  const LaneGroup& group_;
  const Lists& lists_;
  const Lists* next_;  // of the next group; null behind the last one
  Workspace &work_, &grove_;
  Arrays in_;
};

}  // namespace tanor::detail
