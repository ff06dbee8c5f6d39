#include "factor/front_tree.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "factor/front_kernels.hpp"
#include "plan/thresholds.hpp"

namespace tanor::detail {

namespace {

std::size_t round_up(std::size_t count) {
  constexpr std::size_t width = kernels::front_width;
  return (count + width - 1) / width * width;
}

std::size_t num_tiles(std::size_t count) {
  return (count + FrontTree::tile - 1) / FrontTree::tile;
}

/// Returns the flops of a front, with the equivalent of the time to add updates and to enter the front.
double cost_of(const Front& front) {
  const auto rows = static_cast<double>(front.rows), columns = static_cast<double>(front.columns);
  const double below = rows - columns;
  // The flops are the sum over the columns of the square of the rows from the diagonal on.
  return (rows * (rows + 1.0) * (2.0 * rows + 1.0) - below * (below + 1.0) * (2.0 * below + 1.0)) / 6.0 +
         12.0 * rows * rows + 5000.0;
}

}  // namespace

FrontTree::FrontTree(const Supernodes& supernodes) {
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    Front front{.first_column = static_cast<std::size_t>(supernodes.first_column[s]),
                .columns = supernodes.num_columns(s),
                .rows = supernodes.rows_of(s).size(),
                .stride = 0,
                .update_stride = 0,
                .parent = supernodes.parent[s]};
    const auto r = static_cast<double>(front.rows);
    front.is_tiled = r * r * static_cast<double>(front.columns) > plan::products_of_tiled_front;
    front.update_stride = round_up(front.below());
    // Tiles of an update have to be whole lanes of the panel.
    front.stride = round_up(front.is_tiled ? front.columns + front.update_stride : front.rows);
    largest_stride = std::max(largest_stride, front.stride);
    fronts.push_back(front);
  }
  link_children(supernodes);
  const std::vector<int> all = depth_first();
  for (const int s : all) {  // in the order in which they are passed through
    Front& front = fronts[static_cast<std::size_t>(s)];
    front.panel = std::exchange(panels_size, panels_size + front.stride * front.columns);
  }
  add_tasks(all);
  place_on_stacks();
  place_shared_updates(all);
  for (Front& front : fronts) {
    if (!front.is_shared() && !front.is_tiled) continue;
    // A tiled front also has room for the sums of each tile.
    const std::size_t sums = front.is_tiled ? tile * num_tiles(front.stride) * num_tiles(front.columns) : 0;
    front.vector = std::exchange(vectors_size, vectors_size + front.stride + sums);
  }
}

void FrontTree::link_children(const Supernodes& supernodes) {
  std::vector<std::size_t> num_children(fronts.size(), 0);
  for (std::size_t s = fronts.size(); s-- > 0;) {
    Front& front = fronts[s];
    if (front.parent < 0) continue;
    Front& parent = fronts[static_cast<std::size_t>(front.parent)];
    const auto end = static_cast<int>(parent.first_column + parent.columns);
    const std::span<const int> below = supernodes.rows_below(s);
    front.rows_in_panel = static_cast<std::size_t>(std::ranges::lower_bound(below, end) - below.begin());
    front.depth = parent.depth + 1;  // parents come later and are met first here
    front.next_sibling = std::exchange(parent.first_child, static_cast<int>(s));
    most_children = std::max(most_children, ++num_children[static_cast<std::size_t>(front.parent)]);
  }
}

/// Orders fronts depth first, so that the update that stands on a stack longest is needed last.
std::vector<int> FrontTree::depth_first() const {
  std::vector<int> next(fronts.size()), result;
  for (std::size_t s = 0; s < fronts.size(); ++s) next[s] = fronts[s].first_child;
  for (std::size_t root = 0; root < fronts.size(); ++root) {
    if (fronts[root].parent >= 0) continue;
    for (int s = static_cast<int>(root); s >= 0;) {
      int& child = next[static_cast<std::size_t>(s)];
      if (child >= 0) {
        s = std::exchange(child, fronts[static_cast<std::size_t>(child)].next_sibling);
        continue;
      }
      result.push_back(s);
      s = fronts[static_cast<std::size_t>(s)].parent;
    }
  }
  return result;
}

/// Decides which fronts are tasks of their own, and cuts what is below them into sequences. What is not worth a second
/// thread stays one sequence, whose updates take the least memory, unless it has a front in tiles.
void FrontTree::add_tasks(const std::vector<int>& all) {
  std::vector<double> of_subtree(fronts.size());
  for (const int s : all) {
    const Front& front = fronts[static_cast<std::size_t>(s)];
    double& own = of_subtree[static_cast<std::size_t>(s)];
    own += cost_of(front);
    (front.parent >= 0 ? of_subtree[static_cast<std::size_t>(front.parent)] : cost) += own;
  }
  const bool is_one_task =
      cost < plan::flops_worth_threads && static_cast<double>(panels_size) < plan::numbers_worth_threads;
  const double share = is_one_task ? std::numeric_limits<double>::infinity()
                                   : std::max(plan::share_of_task * cost, plan::least_cost_of_task);
  std::vector<int> last(fronts.size(), -1), before;  // last: [front] the task that ends it
  double open = 0.0;
  sequence_start_.push_back(0);
  const auto close = [&] {
    if (order_.size() == sequence_start_.back()) return;
    const int task = add({FrontTask::Kind::Sequence, sequence_start_.size() - 1}, open);
    for (std::size_t k = sequence_start_.back(); k < order_.size(); ++k) last[order_[k]] = task;
    sequence_start_.push_back(order_.size());
    open = 0.0;
  };
  for (const int number : all) {
    const auto s = static_cast<std::size_t>(number);
    Front& front = fronts[s];
    front.is_top = front.is_tiled || of_subtree[s] > share;
    for_children(front, [&](std::size_t, const Front& child) { front.is_top = front.is_top || child.is_top; });
    if (!front.is_top) {
      order_.push_back(s);
      open += cost_of(front);
      const bool ends_subtree = front.parent < 0 || of_subtree[static_cast<std::size_t>(front.parent)] > share;
      if (ends_subtree && open > 0.5 * share) close();
      continue;
    }
    close();
    before.clear();
    for_children(front, [&](std::size_t c, const Front&) {
      fronts[c].home = Front::Home::Arena;
      before.push_back(last[c]);
    });
    last[s] = add_front(s, before);
  }
  close();
  graph_.finish();
}

/// Places the updates inside sequences on two stacks. The update of a front is never on the stack of its children's.
void FrontTree::place_on_stacks() {
  for (std::size_t q = 0; q + 1 < sequence_start_.size(); ++q) {
    std::size_t top[2] = {0, 0};
    for (std::size_t k = sequence_start_[q]; k < sequence_start_[q + 1]; ++k) {
      Front& front = fronts[order_[k]];
      const std::size_t here = front.depth % 2;
      if (!front.is_shared()) {
        front.update = std::exchange(top[here], top[here] + front.update_size());
        stack_size[here] = std::max(stack_size[here], top[here]);
      }
      // The updates of the children are released. The one that was placed first stands lowest.
      for_children(front,
                   [&](std::size_t, const Front& child) { top[1 - here] = std::min(top[1 - here], child.update); });
    }
  }
}

namespace {

/// The updates that share one array.
class Room {
 public:
  /// Returns the first place for `size` numbers that overlaps no update for which `meets(front)` says that both may be
  /// there at the same time. A result beyond `capacity` - size means that there is no such place.
  template <class Meets>
  std::size_t first_gap(std::size_t size, std::size_t capacity, const Meets& meets) const {
    std::size_t result = 0;
    for (const Stay& stay : stays_) {  // in the order of their places
      if (stay.first >= result + size || result + size > capacity) break;
      if (stay.end > result && meets(stay.front)) result = stay.end;
    }
    return result;
  }
  void add(std::size_t front, std::size_t first, std::size_t size) {
    const auto after = std::ranges::upper_bound(stays_, first, {}, &Stay::first);
    stays_.insert(after, {front, first, first + size});
  }

 private:
  struct Stay {
    std::size_t front, first, end;
  };
  std::vector<Stay> stays_;
};

}  // namespace

/// Places updates that pass between tasks. An update exists from the factorization of its front until its parent has
/// read it. So it never meets the update of a front two or more generations above or below, nor the panel of a front
/// two or more generations above, which is written later. Updates are placed from the roots down, large ones first,
/// because those near the roots have the fewest panels to choose from.
void FrontTree::place_shared_updates(const std::vector<int>& all) {
  std::vector<std::size_t> place(fronts.size()), first_below(fronts.size());  // in `all`, where subtrees are ranges
  std::vector<std::size_t> shared;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto s = static_cast<std::size_t>(all[k]);
    place[s] = first_below[s] = k;
    for_children(fronts[s],
                 [&](std::size_t c, const Front&) { first_below[s] = std::min(first_below[s], first_below[c]); });
    if (fronts[s].is_shared()) shared.push_back(s);
  }
  std::ranges::stable_sort(shared, [this](std::size_t a, std::size_t b) {
    const Front &front = fronts[a], &other = fronts[b];
    return front.depth != other.depth ? front.depth < other.depth : front.update_size() > other.update_size();
  });
  const auto is_far_above = [&](std::size_t upper, std::size_t lower) {
    return fronts[lower].depth >= fronts[upper].depth + 2 && first_below[upper] <= place[lower] &&
           place[lower] < place[upper];
  };
  std::vector<Room> panels(fronts.size());
  Room arena;
  for (const std::size_t s : shared) {
    Front& front = fronts[s];
    const std::size_t size = front.update_size();
    const auto meets = [&](std::size_t other) { return !is_far_above(s, other) && !is_far_above(other, s); };
    int above = fronts[static_cast<std::size_t>(front.parent)].parent;
    for (std::size_t k = 0; k < plan::most_panels_tried && above >= 0 && front.home == Front::Home::Arena; ++k) {
      const Front& upper = fronts[static_cast<std::size_t>(above)];
      Room& panel = panels[static_cast<std::size_t>(above)];
      const std::size_t capacity = upper.stride * upper.columns;
      if (const std::size_t gap = panel.first_gap(size, capacity, meets); gap + size <= capacity) {
        front.home = Front::Home::Panels;
        front.update = upper.panel + gap;
        panel.add(s, gap, size);
      }
      above = upper.parent;
    }
    if (front.home == Front::Home::Panels) continue;
    front.update = arena.first_gap(size, std::numeric_limits<std::size_t>::max(), meets);
    arena.add(s, front.update, size);
    arena_size = std::max(arena_size, front.update + size);
  }
}

/// Adds a front that waits for the tasks before. Of tiles it adds those of its panel, column by column, then those of
/// its update. A tile of L waits for the tile on its left and for the diagonal tile of its columns, and so for all that
/// it reads. Returns the task that waits for all of the front, or -1 if it has tiles and no rows below.
int FrontTree::add_front(std::size_t s, const std::vector<int>& before) {
  const Front& front = fronts[s];
  if (!front.is_tiled) {
    const int task = add({FrontTask::Kind::Whole, s}, cost_of(front));
    for (const int earlier : before) graph_.link(earlier, task);
    return task;
  }
  const std::size_t rows = num_tiles(front.stride), columns = num_tiles(front.columns);
  constexpr auto area = static_cast<double>(tile * tile);
  std::vector<int> left(rows);
  for (std::size_t column = 0; column < columns; ++column) {
    int diagonal = -1;
    for (std::size_t row = column; row < rows; ++row) {
      const double depth = 2.0 * static_cast<double>(tile * column) + static_cast<double>(tile);
      const int task = add({FrontTask::Kind::PanelTile, s, row, column}, depth * area);
      if (column > 0) graph_.link(left[row], task);
      if (row > column) graph_.link(diagonal, task);
      if (row == column) diagonal = task;
      left[row] = task;
    }
    if (column > 0) continue;
    for (const int earlier : before) graph_.link(earlier, diagonal);
  }
  if (front.below() == 0) return -1;
  std::vector<int> updates;
  const std::size_t sides = num_tiles(front.below());
  const auto link_rows = [&](std::size_t of, int task) {
    const std::size_t first = front.columns + of * tile, end = std::min(first + tile, front.stride);
    for (std::size_t row = first / tile; row * tile < end; ++row) graph_.link(left[row], task);
  };
  for (std::size_t column = 0; column < sides; ++column) {
    for (std::size_t row = column; row < sides; ++row) {
      const double flops = 2.0 * static_cast<double>(front.columns) * area;
      const int task = add({FrontTask::Kind::UpdateTile, s, row, column}, flops);
      link_rows(row, task);
      if (row > column) link_rows(column, task);
      updates.push_back(task);
    }
  }
  const int join = add({FrontTask::Kind::Join, s}, static_cast<double>(front.rows));
  for (const int task : updates) graph_.link(task, join);
  return join;
}

}  // namespace tanor::detail
