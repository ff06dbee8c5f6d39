#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.hpp"
#include "plan/thresholds.hpp"
#include "schur/tree_lanes.hpp"

namespace tanor::detail {

/// One grove, and the threads that work on it. A thread that is alone has a workspace of its own.
class GroveVisit {
 public:
  GroveVisit(TreeLanes* all, std::size_t number, const Parallel& parallel, std::size_t workspace)
      : all_(*all),
        number_(number),
        parallel_(parallel),
        workspace_(workspace),
        num_workspaces_(all->num_workspaces(parallel)) {}

  std::size_t number() const { return number_; }
  const Grove& grove() const { return all_.pieces().groves[number_]; }

  void bring(const PointSource* source) const {
    const std::vector<RodTree>& trees = all_.pieces().trees;
    for (std::size_t tree = grove().first_tree; source != nullptr && tree < grove().end_tree; ++tree)
      detail::bring(parallel_, source, static_cast<std::size_t>(trees[tree].first_point),
                    static_cast<std::size_t>(trees[tree].end_point));
  }
  const PieceGroup& first_group() const { return all_.pieces().groups[grove().first_group()]; }
  std::size_t workspace() const { return workspace_; }

  /// Calls work(group) for each group from a level on, the lower levels first.
  template <class Work>
  void up(const Work& work, std::size_t lowest = 0) const {
    for (std::size_t level = lowest; level + 1 < grove().level_start.size(); ++level) take_level(level, work);
  }
  /// Does the same for the upper levels first.
  template <class Work>
  void down(const Work& work, std::size_t lowest = 0) const {
    for (std::size_t level = grove().level_start.size() - 1; level-- > lowest;) take_level(level, work);
  }
  template <class Work>
  void take_level(std::size_t level, const Work& work) const {
    const std::vector<PieceGroup>& groups = all_.pieces().groups;
    const std::size_t first = grove().level_start[level], count = grove().level_start[level + 1] - first;
    if (count == 0) return;
    const std::size_t last = first + count - 1;
    const std::size_t num_rods = (groups[last].first_rod + groups[last].num_rods - groups[first].first_rod) * num_lanes;
    const std::size_t shares =
        std::clamp<std::size_t>(num_rods / plan::rows_of_batches_worth_a_thread, 1, num_workspaces_);
    parallel_.for_tasks(shares, [&](std::size_t share) {
      for (std::size_t k = count * share / shares; k < count * (share + 1) / shares; ++k) {
        TreeLanes::Group group(&all_, first + k, shares == 1 ? workspace_ : share);
        work(group);
      }
    });
  }

 private:
  TreeLanes& all_;
  std::size_t number_;
  const Parallel& parallel_;
  std::size_t workspace_, num_workspaces_;
};

/// Calls work(visit) for each grove. All threads work on a grove that is more than one thread's share, one after the
/// other; each of the others belongs to one thread.
template <class Work>
void visit_groves(const Parallel& parallel, TreeLanes* all, const Work& work) {
  const std::vector<Grove>& groves = all->pieces().groves;
  const std::size_t total = all->pieces().num_rods;
  const std::size_t shares =
      std::clamp<std::size_t>(total / plan::rows_of_batches_worth_a_thread, 1, all->num_workspaces(parallel));
  const auto is_shared = [&](const Grove& grove) { return shares > 1 && grove.num_rods * shares > total; };
  for (std::size_t grove = 0; grove < groves.size(); ++grove) {
    if (is_shared(groves[grove])) work(GroveVisit(all, grove, parallel, 0));
  }
  const Parallel alone(1);
  parallel.for_tasks(shares, [&](std::size_t share) {
    std::size_t before = 0;
    for (std::size_t grove = 0; grove < groves.size(); before += groves[grove++].num_rods) {
      if (before * shares / total == share && !is_shared(groves[grove])) work(GroveVisit(all, grove, alone, share));
    }
  });
}

}  // namespace tanor::detail
