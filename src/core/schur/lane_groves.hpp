#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "schur/lane_groups.hpp"

namespace tanor::detail {

/// One grove, and the threads that work on it. A thread that is alone has a workspace of its own.
class GroveVisit {
 public:
  GroveVisit(LaneGroups* all, Pass pass, std::size_t number, const Parallel& parallel, std::size_t workspace)
      : all_(*all),
        pass_(pass),
        number_(number),
        parallel_(parallel),
        levels_(all->plan().levels(number)),
        groups_(all->plan().groups.begin() + static_cast<std::ptrdiff_t>(levels_.front()),
                all->plan().groups.begin() + static_cast<std::ptrdiff_t>(levels_.back())),
        workspace_(workspace) {}

  bool stands_alone() const { return groups_.front().stands_alone; }
  bool is_of_paths() const { return all_.plan().is_of_paths(); }
  std::span<const LaneGroup> groups() const { return groups_; }
  LanePlan::Extent extent() const { return all_.plan().extent(number_); }
  std::size_t first_island() const { return all_.plan().island_start[number_]; }
  std::size_t end_island() const { return all_.plan().island_start[number_ + 1]; }
  std::size_t workspace() const { return workspace_; }

  /// Brings all points, but those of a path that one thread goes along, each group of which brings its own.
  void bring(const PointSource* source) const {
    if (source == nullptr || goes_along_path()) return;
    for (std::size_t island = first_island(); island < end_island(); ++island)
      bring(source, all_.plan().islands[island].first_point, all_.plan().islands[island].end_point);
  }
  void bring_for(const PointSource* source, const LaneGroup& group) const {
    if (source == nullptr || !goes_along_path()) return;
    const auto [first, end] = all_.plan().islands[first_island()];
    const Index begin = &group == groups_.data() ? first : next_point_;
    const Index last = all_.plan().point[(group.first_place + group.num_places) * num_lanes - 1];
    // Groups of single rods are the last ones.
    next_point_ = group.num_rods > 1 ? (last < 0 ? ~last : last) + 1 : end;
    bring(source, begin, next_point_);
  }

  // ---- the separators of a path; nothing is done where there is none ----
  void factorize_separators() const {
    Pack<>& largest = all_.workspaces()[workspace_].found.largest_inverse;
    for_each_path([&](std::size_t path) { largest[0] = larger(largest[0], all_.separators(path).factorize()); });
  }
  void solve_separators(bool have_points_in_lanes = false) const {
    for_each_path([&](std::size_t path) {
      if (have_points_in_lanes) all_.separators(path).join_points();
      all_.separators(path).solve();
    });
  }
  /// Hands on the multipliers that they have.
  void hand_on_separators() const {
    for_each_path([&](std::size_t path) { all_.separators(path).hand_on(); });
  }
  /// Calls visit(path) for each path.
  template <class Visit>
  void for_each_path(const Visit& visit) const {
    for (std::size_t path = first_island(); is_of_paths() && path < end_island(); ++path) visit(path);
  }

  /// Calls work(group) for each group, the lower levels first.
  template <class Work>
  void up(const Work& work) const {
    for (std::size_t level = 0; level + 1 < levels_.size(); ++level) take_level(level, work);
  }
  /// Does the same for the upper levels first.
  template <class Work>
  void down(const Work& work) const {
    for (std::size_t level = levels_.size() - 1; level-- > 0;) take_level(level, work);
  }
  template <class Work>
  void take_level(std::size_t level, const Work& work) const {
    const std::size_t first = levels_[level], count = levels_[level + 1] - first;
    std::size_t shares = 1;
    if (count > 1 && parallel_.threads() > 1) {
      const LaneGroup &front = all_.plan().groups[first], &back = all_.plan().groups[first + count - 1];
      shares = all_.num_shares(back.first_rod + back.num_rods - front.first_rod, parallel_);
    }
    parallel_.for_tasks(shares, [&](std::size_t share) {
      for (std::size_t k = count * share / shares; k < count * (share + 1) / shares; ++k) {
        LaneGroups::Group group(&all_, pass_, first + k, levels_.front(), workspace_, shares == 1 ? workspace_ : share);
        work(group);
      }
    });
  }

 private:
  bool goes_along_path() const {
    return is_of_paths() && end_island() - first_island() == 1 && parallel_.threads() == 1;
  }
  void bring(const PointSource* source, Index begin, Index end) const {
    detail::bring(parallel_, source, static_cast<std::size_t>(begin), static_cast<std::size_t>(end));
  }

  LaneGroups& all_;
  Pass pass_;
  std::size_t number_;
  const Parallel& parallel_;
  std::span<const std::size_t> levels_;
  std::span<const LaneGroup> groups_;
  std::size_t workspace_;
  mutable Index next_point_ = 0;  // the first one that was not brought: groups of a path go in their order
};

/// Calls work(visit) for each grove. All threads work on a grove that is more than one thread's share, one after the
/// other; each of the others belongs to one thread.
template <class Work>
void visit_groves(const Parallel& parallel, LaneGroups* all, Pass pass, const Work& work) {
  all->hold(pass);
  const LanePlan& plan = all->plan();
  const std::size_t total = plan.num_slots(), shares = all->num_shares(total, parallel);
  const auto is_shared = [&](const GroveVisit& visit) { return shares > 1 && visit.extent().rods * shares > total; };
  for (std::size_t grove = 0; shares > 1 && grove < plan.num_groves(); ++grove) {
    if (const GroveVisit visit(all, pass, grove, parallel, 0); is_shared(visit)) work(visit);
  }
  const auto first_grove = [&](std::size_t share) {
    std::size_t grove = 0;
    while (grove < plan.num_groves() && plan.groups[plan.levels(grove).front()].first_rod < total * share / shares)
      ++grove;
    return grove;
  };
  const Parallel alone(1);
  parallel.for_tasks(shares, [&](std::size_t share) {
    const std::size_t end = share + 1 < shares ? first_grove(share + 1) : plan.num_groves();
    for (std::size_t grove = first_grove(share); grove < end; ++grove) {
      if (const GroveVisit visit(all, pass, grove, alone, share); !is_shared(visit)) work(visit);
    }
  });
}

}  // namespace tanor::detail
