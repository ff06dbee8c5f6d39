#include "schur/equal_branches.hpp"

#include <algorithm>
#include <functional>
#include <map>
#include <utility>

#include "plan/thresholds.hpp"

namespace tanor::detail {

std::optional<RodTree> RodTree::read(const RodRows& given, const Numbering& numbering, Index island) {
  const auto number = static_cast<std::size_t>(island);
  const auto num_moving = static_cast<Index>(numbering.num_moving);
  RodTree result;
  result.first_point = num_moving;
  std::size_t num_between = 0;
  Index before = -1;
  for (Index row = numbering.island_start[number]; row < numbering.island_start[number + 1]; ++row) {
    const auto [i, j] = given.ends[static_cast<std::size_t>(row)];
    if (i < 0) return std::nullopt;
    const Index low = std::min(i, j), high = std::max(i, j);
    result.first_point = std::min(result.first_point, low);
    if (high >= num_moving) {
      result.end_point = std::max(result.end_point, low + 1);
      result.rods.push_back({row, high, low});
      continue;
    }
    // In a tree, each point but the root has one rod towards the root: the only row with this point as its lower one.
    if (low <= before) return std::nullopt;
    before = low;
    ++num_between;
    result.end_point = std::max(result.end_point, high + 1);
    result.rods.push_back({row, low, high});
  }
  if (num_between + 1 != result.num_points()) return std::nullopt;
  return result;
}

namespace {

/// The branches of a tree, each named by its root. Points are counted from the tree's first one.
struct Branches {
  std::vector<Index> parent, row;  // [point] for the rod towards the root; -1 at the root
  std::vector<Index> first;        // [point] the lowest point of its branch
  std::vector<int> shape;          // [point] -1 if it cannot be eliminated in lanes
};

/// Numbers the shapes. A shape is given by the shapes of the branches that hang on its root, in their order.
class Shapes {
 public:
  int number_of(const std::vector<int>& branches) {
    return numbers_.try_emplace(branches, static_cast<int>(numbers_.size())).first->second;
  }

 private:
  std::map<std::vector<int>, int> numbers_;
};

Branches list_branches(const RodTree& tree, Shapes* shapes) {
  const std::size_t num_points = tree.num_points();
  Branches result;
  result.parent.assign(num_points, -1);
  result.row.assign(num_points, -1);
  result.first.resize(num_points);
  result.shape.assign(num_points, -1);
  std::vector<char> is_held(num_points, 0);  // true if a support holds the point
  std::vector<int> num_children(num_points, 0);
  for (const auto& [row, child, parent] : tree.rods) {
    const auto to = static_cast<std::size_t>(parent - tree.first_point);
    if (child >= tree.end_point) {
      is_held[to] = 1;
      continue;
    }
    const auto from = static_cast<std::size_t>(child - tree.first_point);
    result.parent[from] = static_cast<Index>(to);
    result.row[from] = row;
    ++num_children[to];
  }
  std::vector<std::size_t> open;  // points whose parents are still to come
  std::vector<int> own;
  for (std::size_t point = 0; point < num_points; ++point) {
    // The branches of a point stand one after the other right before the point, and so do their rows.
    bool is_whole = true;
    std::size_t first = point;
    own.clear();
    while (!open.empty() && result.parent[open.back()] == static_cast<Index>(point)) {
      const std::size_t child = open.back();
      open.pop_back();
      is_whole = is_whole && result.shape[child] >= 0 && is_held[child] == 0;
      own.push_back(result.shape[child]);
      first = static_cast<std::size_t>(result.first[child]);
    }
    open.push_back(point);
    result.first[point] = static_cast<Index>(first);
    const std::size_t num_rods = point - first;
    is_whole = is_whole && num_rods <= plan::most_rods_of_branch && std::ssize(own) == num_children[point];
    if (num_rods > 0) {
      const Index last_row = result.row[point - 1], first_row = result.row[first];
      is_whole = is_whole && last_row - first_row + 1 == static_cast<Index>(num_rods);
    }
    if (is_whole) result.shape[point] = shapes->number_of(own);
  }
  return result;
}

}  // namespace

EqualBranches::EqualBranches(std::span<const RodTree> trees) {
  struct Root {
    std::size_t tree, point;
  };
  Shapes shapes;
  std::vector<Branches> all;
  std::map<std::pair<std::size_t, int>, std::vector<Root>, std::greater<>> roots;  // by size, then shape
  for (std::size_t tree = 0; tree < trees.size(); ++tree) {
    all.push_back(list_branches(trees[tree], &shapes));
    is_inside.emplace_back(trees[tree].num_points(), char{0});
    const Branches& branches = all.back();
    for (std::size_t point = 0; point < branches.shape.size(); ++point) {
      const std::size_t size = point - static_cast<std::size_t>(branches.first[point]) + 1;
      if (branches.shape[point] >= 0 && size > plan::fewest_rods_of_branch)
        roots[{size, branches.shape[point]}].push_back({tree, point});
    }
  }
  std::size_t num_rods = 0, num_places = 0;
  std::vector<std::vector<char>> is_taken = is_inside;
  for (auto& [key, of_shape] : roots) {
    std::erase_if(of_shape, [&](const Root& root) { return is_taken[root.tree][root.point] != 0; });
    const std::size_t size = key.first, count = of_shape.size() / num_lanes * num_lanes;
    if (count == 0) continue;
    const auto first_of = [&](const Root& root) { return static_cast<std::size_t>(all[root.tree].first[root.point]); };
    std::vector<Index>& parent = parents.emplace_back();
    const Root& any = of_shape.front();
    for (std::size_t k = first_of(any); k < any.point; ++k)
      parent.push_back(all[any.tree].parent[k] - static_cast<Index>(first_of(any)));
    for (std::size_t k = 0; k < count; ++k) {
      const Root& root = of_shape[k];
      if (k % num_lanes == 0) {
        batches.push_back({.shape = parents.size() - 1, .first_rod = num_rods, .first_place = num_places});
        num_rods += size - 1;
        num_places += size;
      }
      const std::size_t first = first_of(root);
      batches.back().first_point[k % num_lanes] = trees[root.tree].first_point + static_cast<Index>(first);
      batches.back().first_row[k % num_lanes] = all[root.tree].row[first];
      for (std::size_t point = first; point <= root.point; ++point) {
        is_taken[root.tree][point] = 1;
        is_inside[root.tree][point] = point < root.point ? 1 : 0;
      }
    }
  }
}

std::size_t EqualBranches::num_rods() const {
  return batches.empty() ? 0 : batches.back().first_rod + shape(batches.back()).num_rods;
}

double EqualBranches::share_in_lanes(std::size_t tree) const {
  const std::vector<char>& inside = is_inside[tree];
  return static_cast<double>(std::ranges::count(inside, 1)) / static_cast<double>(inside.size());
}

TreesInLanes::TreesInLanes(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands)
    : branches(std::span<const RodTree>()) {
  std::vector<Index> numbers;
  for (const Index island : *islands) {
    std::optional<RodTree> tree = RodTree::read(rods, numbering, island);
    if (!tree.has_value()) continue;
    trees.push_back(std::move(*tree));
    numbers.push_back(island);
  }
  branches = EqualBranches(trees);
  if (!eagerly) {
    std::size_t kept = 0;
    for (std::size_t tree = 0; tree < trees.size(); ++tree) {
      if (branches.share_in_lanes(tree) < plan::share_of_tree_in_lanes) continue;
      std::swap(trees[kept], trees[tree]);
      numbers[kept++] = numbers[tree];
    }
    const bool keeps_all = kept == trees.size();
    trees.resize(kept);
    numbers.resize(kept);
    if (!keeps_all) branches = EqualBranches(trees);
  }
  std::erase_if(*islands, [&](Index island) { return std::ranges::binary_search(numbers, island); });
}

}  // namespace tanor::detail
