#pragma once

#include <cstddef>
#include <vector>

#include "base/task_graph.hpp"
#include "factor/front_kernels.hpp"
#include "factor/supernodes.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

/// A dense lower triangle with the rows of a supernode.
struct Front {
  std::size_t first_column, columns, rows, stride;  // stride: that of its panel [rows, columns]
  std::size_t panel = 0;                            // its place among the panels
  std::size_t update = 0, update_stride;            // its place, see `home`
  std::size_t vector = 0;                           // place of a shared front among the vectors [stride] of a solve
  std::size_t depth = 0;
  std::size_t rows_in_panel = 0;  // rows of its update that are among its parent's columns
  int parent = -1, first_child = -1, next_sibling = -1;
  /// The place of its update. It is a stack of the thread, chosen by depth % 2; if one task writes the update and
  /// another one reads it, it is the panels or the arena.
  enum class Home { Stack, Panels, Arena } home = Home::Stack;
  bool is_top = false;    // true if it is a task of its own, or many
  bool is_tiled = false;  // true if it is many tasks

  bool is_shared() const { return home != Home::Stack; }
  std::size_t below() const { return rows - columns; }
  std::size_t update_size() const { return kernels::Triangle::size(below(), update_stride); }
};

/// One task of a factorization and of both substitutions of a solve, in which tiles of updates have nothing to do.
struct FrontTask {
  enum class Kind { Sequence, Whole, PanelTile, UpdateTile, Join };
  Kind kind;
  std::size_t front;                // or the number of a sequence
  std::size_t row = 0, column = 0;  // position of a tile
};

/// Fronts in the order of elimination, tasks over them, and the places of their numbers. All of it follows from the
/// pattern alone, and so do the operations and their order, whatever the number of threads.
///
/// A front whose subtree costs more than a share of the total is a task, or many tiles if it is large. The fronts below
/// are cut into sequences: subtrees side by side whose updates stand on two stacks that each thread has. Updates that
/// pass from task to task stand in panels that are not written yet: the update of a front may stand in the panel of any
/// front from its grandparent on upwards. Updates that find no room there stand in the arena.
struct FrontTree {
  static constexpr std::size_t tile = plan::rows_of_tile;  ///< rows and columns

  explicit FrontTree(const Supernodes& supernodes);

  std::vector<Front> fronts;  ///< [supernode]
  std::size_t stack_size[2] = {0, 0}, arena_size = 0, panels_size = 0, vectors_size = 0, largest_stride = 0;
  std::size_t most_children = 0;  ///< largest number of children of a front
  double cost = 0.0;              ///< cost of a factorization in flops

  /// Calls body(task, thread) for all tasks, and for each front of a sequence.
  template <class Body>
  void run(int threads, TaskGraph::Direction direction, const Body& body) {
    graph_.run(threads, direction, [&](int number, int worker) {
      const FrontTask& task = tasks_[static_cast<std::size_t>(number)];
      const auto thread = static_cast<std::size_t>(worker);
      if (task.kind != FrontTask::Kind::Sequence) return body(task, thread);
      const std::size_t first = sequence_start_[task.front], end = sequence_start_[task.front + 1];
      for (std::size_t k = first; k < end; ++k) {
        const bool goes_forwards = direction == TaskGraph::Direction::Forwards;
        body(FrontTask{FrontTask::Kind::Whole, order_[goes_forwards ? k : first + end - 1 - k]}, thread);
      }
    });
  }
  template <class Visit>
  void for_children(const Front& front, const Visit& visit) const {
    for (int child = front.first_child; child >= 0; child = fronts[static_cast<std::size_t>(child)].next_sibling)
      visit(static_cast<std::size_t>(child), fronts[static_cast<std::size_t>(child)]);
  }

 private:
  std::vector<int> depth_first() const;
  void link_children(const Supernodes& supernodes);
  void add_tasks(const std::vector<int>& all);
  int add_front(std::size_t s, const std::vector<int>& before);
  void place_on_stacks();
  void place_shared_updates(const std::vector<int>& all);
  int add(const FrontTask& task, double of_task) {
    tasks_.push_back(task);
    return graph_.add(of_task);
  }

  std::vector<std::size_t> order_;           // fronts of the sequences, children before parents
  std::vector<std::size_t> sequence_start_;  // [sequence + 1] into `order_`
  std::vector<FrontTask> tasks_;
  TaskGraph graph_;
};

}  // namespace tanor::detail
