#pragma once

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "base/pack.hpp"
#include "base/parallel.hpp"
#include "schur/group_transfers.hpp"
#include "schur/lane_kernels.hpp"
#include "schur/lane_plan.hpp"
#include "schur/path_separators.hpp"
#include "schur/schur_solver.hpp"

namespace tanor::detail {

/// Says what groups keep in lanes while a call is in other groups: of paths, in a `Single` pass, no more than b and
/// what was found, since they go through memory; in `Repeated` passes rods and points, as all others do in any case;
/// and in a `Projection` also directions and sums.
enum class Pass { Single, Repeated, Projection };

/// Groups of islands, or of pieces of trees and paths, in lanes: their rods with the factor, and what pieces hand to
/// one another.
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
  std::span<Separator> separators(std::size_t path) {
    const auto [first, end, is_ring] = plan_.paths[path];
    return std::span(separators_).subspan(first, end - first);
  }

  class Group;

  /// The arrays of a thread.
  struct Workspace {
    // of one group, [place]
    std::vector<Pack3<>> r, v, w, s, dw;
    std::vector<lanes::Mobility> mobility;
    lanes::Border border;
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
  /// Lengths of rods [rod], l' and l''; these are empty if no length moves.
  struct Lengths {
    Packs value, first, second;
  };
  void read_rods(const RodRows& given);
  void read_masses(std::span<const double> inverse_mass);
  void find_places();
  void prepare_workspaces(int threads);
  template <class Visit>
  void for_each_rod(const Visit& visit) const;

  LanePlan plan_;
  Index num_moving_;
  std::vector<Index> block_;                                                 // [rod][lane]; ~block if it is turned
  std::vector<GroupTransfers::Places> places_;                               // [group]
  Packs inverse_mass_;                                                       // [place]
  Packs inverse_masses_;                                                     // [rod] of trees: both ends, summed
  std::vector<Pack3<>> offset_;                                              // [rod] of groups that have some
  bool are_shifted_ = false;                                                 // true if there are offsets of rods
  Lengths lengths_;                                                          // of rods
  std::vector<std::pair<std::size_t, const MovingScalar*>> moving_lengths_;  // by rod and lane
  std::vector<Pack3<>> u_;                                                   // [rod] of trees
  Packs factor_;
  std::vector<lanes::Joint> joints_;   // [group] of pieces of trees
  std::vector<Separator> separators_;  // of pieces of paths
  std::vector<Workspace> workspaces_;  // [thread]
};

/// One group in the lanes of the workspaces of a thread and of its grove.
class LaneGroups::Group : public GroupTransfers {
 public:
  Group(LaneGroups* all, Pass pass, std::size_t group, std::size_t first_group, std::size_t of_grove,
        std::size_t of_thread);

  // ---- up ----
  /// Reads r, v and w0 of the points. The next group will write its part of `blocks`.
  lanes::Motion read_motion(const FreeMotion& motion, const double* blocks);
  void evaluate(const lanes::Motion& motion);
  void eliminate();
  void evaluate_and_eliminate(const lanes::Motion& motion);
  void substitute_up();

  /// Does all of a solve of a group that stands alone.
  void solve(const lanes::Motion& motion, const Vec3* uniform, FactorUse use, double* w);

  // ---- down ----
  /// Finds lambda, unless it is known, and the forces of the rods, which joints hand down with the `known` ones [place]
  /// unless these are null, and computes points += dw [place] unless these are null.
  void substitute_down(Pack3<>* points = nullptr, const Pack3<>* known = nullptr, bool lambda_is_known = false);
  /// Finds lambda and computes w := w0 + dw, and the residual unless there are joints. w0 is in w unless it is
  /// `uniform`.
  void substitute_down(const double* blocks, const Vec3* uniform, double* w);
  /// Finds the residual once all pieces below joints are through.
  void find_residual();

  /// Reads u of separators, and their multipliers unless `rows` are null.
  void read_separators(const double* blocks, const double* rows = nullptr);

  // ---- projections ----
  /// Evaluates the violation of `points`, positions or velocities.
  void evaluate_values();
  void evaluate_rates();
  void add_multipliers();
  /// Finds lambda, unless it is known, and computes points += dw in memory. Separators have theirs.
  void move(const double* blocks, bool lambda_is_known, double* points);

  // ---- what pieces hand to one another ----
  /// Sets s of joints to the answer of what hangs there, with that to the `force` [place] on them unless it is null.
  void answer_at_joints(const Pack3<>* force);
  void hand_over_answers();
  /// Takes the numbers of the roots there at joints, and behind pieces of a path those of the next one's first point.
  void take_joints(Pack3<>* points);
  /// Hands over what these pieces of a path add to the points before and behind them; nothing if `points` is null.
  void hand_over_ends(const Pack3<>* points);

  // ---- in and out ----
  void find_directions(const double* r, Pack3<>* u);
  void read_directions(const double* blocks, bool are_new = false);

  // ---- the arrays ----
  const LaneGroup& plan() const { return group_; }
  using Arrays = lanes::Arrays;
  const Arrays& arrays() const { return in_; }
  /// The group's part of the arrays of its grove. Points, directions and sums of paths may be the thread's.
  struct Own {
    Pack3<>*points, *directions;         ///< positions or velocities that are projected; u there
    Pack<>*sum, *right_side, *residual;  ///< sums of multipliers [rod]; what was found
  };
  const Own& own() const { return own_; }
  Pack3<>* scratch() { return work_.s.data(); }  ///< [place]
  /// Returns the parts of the distances [rod] that are not between the points; null if there are none.
  const Pack3<>* offsets() const;

 private:
  using Joint = lanes::Joint;
  Joint& own_joint() { return all_.joints_[number_]; }
  std::span<const JointPlace> joints() const {
    return std::span(all_.plan_.joints).subspan(group_.first_joint, group_.end_joint - group_.first_joint);
  }
  bool is_path() const { return all_.plan_.is_of_paths(); }
  bool is_tree() const { return all_.plan_.is_of_trees(); }
  bool may_hang() const { return is_tree() && !group_.stands_alone; }
  /// Calls visit(separator, lane) for the last rods of pieces of a path.
  template <class Visit>
  void for_separators(const Visit& visit) const;
  Separator* neighbour(std::size_t lane, bool is_behind) const;
  void take_mobilities();
  void take_separators();
  lanes::Upcoming upcoming(std::array<const double*, 3> arrays) const;
  void hand_over_factor();
  void hand_over_roots(const Pack3<>* points);

  LaneGroups& all_;
  std::size_t number_;
  const LaneGroup& group_;
  Workspace &work_, &grove_;
  Own own_;
  Arrays in_;
};

}  // namespace tanor::detail
