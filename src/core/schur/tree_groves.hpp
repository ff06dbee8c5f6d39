#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "base/parallel.hpp"
#include "plan/thresholds.hpp"
#include "schur/equal_branches.hpp"

namespace tanor::detail {

/// Trees whose branches share batches with those of no other tree. Groves are solved one after the other, each as long
/// as it is in the cache.
struct Grove {
  std::vector<std::size_t> trees, batches;
  std::size_t num_rods = 0;
};

/// Lists the groves by their first trees.
std::vector<Grove> list_groves(std::span<const RodTree> trees, const EqualBranches& branches);

/// One grove, and the threads that work on it. A thread that is alone has a workspace of its own.
class GroveVisit {
 public:
  GroveVisit(const Grove& grove, std::size_t number, const Parallel& parallel, std::size_t workspace,
             std::size_t num_workspaces)
      : grove_(grove), number_(number), parallel_(parallel), workspace_(workspace), num_workspaces_(num_workspaces) {}

  const Grove& grove() const { return grove_; }
  std::size_t number() const { return number_; }
  const Parallel& parallel() const { return parallel_; }
  std::size_t workspace() const { return workspace_; }

  /// Calls work(batch, workspace) for each batch. Each thread takes some, with a workspace of its own.
  template <class Work>
  void for_each_batch(const Work& work) const {
    const std::size_t worthwhile = grove_.num_rods / plan::rows_of_batches_worth_a_thread,
                      count = grove_.batches.size();
    const std::size_t most = std::min(num_workspaces_, static_cast<std::size_t>(parallel_.threads()));
    const std::size_t shares = std::clamp<std::size_t>(worthwhile, 1, most);
    parallel_.for_tasks(shares, [&](std::size_t share) {
      for (std::size_t k = count * share / shares; k < count * (share + 1) / shares; ++k)
        work(grove_.batches[k], shares == 1 ? workspace_ : share);
    });
  }
  /// Calls work(tree) for each tree.
  template <class Work>
  void for_each_tree(const Work& work) const {
    const std::size_t rods_a_tree = grove_.num_rods / grove_.trees.size() + 1;
    parallel_.for_ranges(
        grove_.trees.size(),
        [&](std::size_t begin, std::size_t end) {
          for (std::size_t k = begin; k < end; ++k) work(grove_.trees[k]);
        },
        plan::rows_worth_a_thread / rods_a_tree + 1);
  }

 private:
  const Grove& grove_;
  std::size_t number_;
  const Parallel& parallel_;
  std::size_t workspace_, num_workspaces_;
};

/// All groves of some trees.
class TreeGroves {
 public:
  TreeGroves(std::span<const RodTree> trees, const EqualBranches& branches);

  std::size_t size() const { return groves_.size(); }
  const Grove& operator[](std::size_t grove) const { return groves_[grove]; }

  /// Calls work(visit) for each grove. All threads work on a grove that is more than one thread's share, one after the
  /// other, with the first workspace for what belongs to the whole grove; each of the others belongs to one thread.
  template <class Work>
  void visit(const Parallel& parallel, std::size_t num_workspaces, const Work& work) const {
    const std::size_t total = rods_before_.back();
    const std::size_t shares = std::clamp<std::size_t>(total / plan::rows_of_batches_worth_a_thread, 1, num_workspaces);
    const auto is_shared = [&](std::size_t grove) { return shares > 1 && groves_[grove].num_rods * shares > total; };
    for (std::size_t grove = 0; grove < size(); ++grove) {
      if (is_shared(grove)) work(GroveVisit(groves_[grove], grove, parallel, 0, num_workspaces));
    }
    const Parallel alone(1);
    const auto first_of = [&](std::size_t share) {
      return static_cast<std::size_t>(std::ranges::lower_bound(rods_before_, total * share / shares) -
                                      rods_before_.begin());
    };
    parallel.for_tasks(shares, [&](std::size_t share) {
      for (std::size_t grove = first_of(share); grove < first_of(share + 1); ++grove) {
        if (!is_shared(grove)) work(GroveVisit(groves_[grove], grove, alone, share, num_workspaces));
      }
    });
  }

 private:
  std::vector<Grove> groves_;
  std::vector<std::size_t> rods_before_;  // [grove] rods of all before it, then of all
};

}  // namespace tanor::detail
