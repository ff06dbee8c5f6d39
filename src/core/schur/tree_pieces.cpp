#include <algorithm>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "base/groups.hpp"
#include "plan/thresholds.hpp"
#include "schur/lane_plan.hpp"

namespace tanor::detail {

namespace {

/// An island of rods without rings, from its leaves to its root in the inner numbering.
struct RodTree {
  /// A rod that joins a point to the next one towards the root. A support may stand in the child's place.
  struct Rod {
    Index row, child, parent;
  };
  Index island = -1, first_point = 0, end_point = 0;
  std::vector<Rod> rods;  ///< by row

  /// Returns true if the tree is one piece. Others stand apart, since their pieces wait for one another.
  bool is_small() const { return rods.size() <= plan::most_rods_of_branch; }
  std::size_t num_points() const { return static_cast<std::size_t>(end_point - first_point); }
};

/// Reads an island. Returns nothing if it has other constraints or rings.
std::optional<RodTree> read_tree(const RodRows& given, const Numbering& numbering, Index island) {
  const auto number = static_cast<std::size_t>(island);
  const auto num_moving = static_cast<Index>(numbering.num_moving);
  RodTree result{.island = island, .first_point = num_moving, .rods = {}};
  std::size_t num_between = 0;
  Index before = -1;
  for (Index row = numbering.island_start[number]; row < numbering.island_start[number + 1]; ++row) {
    const auto [i, j] = given.ends[static_cast<std::size_t>(row)];
    if (i < 0) return std::nullopt;
    const Index low = std::min(i, j), high = std::max(i, j);
    const bool has_support = high >= num_moving;
    // In a tree, each point but the root has one rod towards the root: the only row with this point as its lower one.
    if (!has_support && low <= std::exchange(before, low)) return std::nullopt;
    num_between += has_support ? 0 : 1;
    result.first_point = std::min(result.first_point, low);
    result.end_point = std::max(result.end_point, (has_support ? low : high) + 1);
    result.rods.push_back(has_support ? RodTree::Rod{row, high, low} : RodTree::Rod{row, low, high});
  }
  if (num_between + 1 != result.num_points()) return std::nullopt;
  return result;
}

constexpr std::size_t packs_of_rod = 4;  // see lanes::RodFactor
constexpr std::size_t none = static_cast<std::size_t>(-1);

/// A piece while trees are cut. `rods` and `parent` begin at `first` in the lists of the cut.
struct Piece {
  std::size_t tree, first, num_rods;
  Index root;
  std::size_t level;          // comes after those of all pieces below
  std::size_t above = none;   // the piece that has the root as a joint; none for the last one of a tree
  std::size_t island = tree;  // in the plan, where trees of one piece are numbered by group
};

/// Cuts one tree after the other into pieces.
class Cut {
 public:
  std::vector<Piece> pieces;
  std::vector<RodTree::Rod> rods;  // piece by piece, each in the order of elimination
  std::vector<Index> parent;       // [rod] place of its parent in the piece

  void add(const RodTree& tree, std::size_t number) {
    const std::size_t count = tree.rods.size(), by_number = count / plan::pieces_of_tree;
    tree_ = &tree;
    most_rods_ = count <= plan::most_rods_of_branch
                     ? count
                     : std::clamp(by_number, 4 * plan::fewest_rods_of_branch, plan::most_rods_of_branch);
    number_ = number;
    points_.assign(tree.num_points(), {});
    const Groups<std::size_t> hanging(points_.size(), [&](const auto& add) {
      for (std::size_t rod = 0; rod < count; ++rod) add(tree.rods[rod].parent - tree.first_point, rod);
    });
    for (Index point = tree.first_point; point < tree.end_point; ++point)
      if (const std::span own = hanging[local(point)]; !own.empty()) visit(point, own);
    close(tree.end_point - 1);
  }

 private:
  struct Point {
    std::vector<std::size_t> rods{};  // below it that are in no piece so far
    std::size_t level = 0;            // of these
    Index place = 0;                  // in the piece that is made
    int height = 0;                   // likewise
    std::size_t last = none;          // the last piece with this root
  };
  bool is_support(Index point) const { return point >= tree_->end_point; }
  std::size_t local(Index point) const { return static_cast<std::size_t>(point - tree_->first_point); }
  Point& at(Index point) { return is_support(point) ? support_ : points_[local(point)]; }
  Point& below(std::size_t rod) { return at(tree_->rods[rod].child); }

  /// Joins what hangs on a point by these rods. Branches become pieces where others reach higher levels, so that pieces
  /// of a level are eliminated side by side, and where they are too large together.
  void visit(Index point, std::span<const std::size_t> hanging) {
    std::size_t level = 0, count = 0;
    for (const std::size_t rod : hanging) level = std::max(level, below(rod).level);
    const auto close_branches = [&](std::size_t most) {
      for (const std::size_t rod : hanging) {
        const Point& branch = below(rod);
        if (branch.rods.size() >= plan::fewest_rods_of_branch && branch.level < most) close(tree_->rods[rod].child);
      }
    };
    close_branches(level);
    for (const std::size_t rod : hanging) count += below(rod).rods.size() + 1;
    if (count > most_rods_) close_branches(none);
    Point& own = at(point);
    for (const std::size_t rod : hanging) {
      Point& branch = below(rod);
      if (!own.rods.empty() && own.rods.size() + branch.rods.size() + 1 > most_rods_) close(point);
      if (own.rods.empty()) own.rods.swap(branch.rods);
      own.rods.insert(own.rods.end(), branch.rods.begin(), branch.rods.end());
      own.rods.push_back(rod);
      own.level = std::max(own.level, branch.level);
      branch.rods = {};
    }
  }
  /// Makes a piece of the rods below a point.
  void close(Index root) {
    Point& own = at(root);
    pieces.push_back({number_, rods.size(), own.rods.size(), root, own.level});
    const auto put = [&](Point& point, std::size_t place) {
      point.place = static_cast<Index>(place);
      if (point.last != none) pieces[point.last].above = pieces.size() - 1;
    };
    for (const std::size_t rod : own.rods) rods.push_back(tree_->rods[rod]);
    const std::span made = std::span(rods).last(own.rods.size());
    if (!follow(made, root)) sort_by_height(made);
    for (std::size_t k = 0; k < made.size(); ++k) put(at(made[k].child), k);
    put(own, made.size());
    for (const RodTree::Rod& rod : made) parent.push_back(at(rod.parent).place);
    own = {.level = own.level + 1, .last = pieces.size() - 1};
  }
  /// Returns true if the rods and points of a piece follow one another in memory, and may be read at once.
  static bool follow(std::span<const RodTree::Rod> own, Index root) {
    const auto count = static_cast<Index>(own.size());
    for (Index k = 0; k < count; ++k) {
      const RodTree::Rod& rod = own[static_cast<std::size_t>(k)];
      if (rod.row != own.front().row + k || rod.child != own.front().child + k) return false;
    }
    return own.empty() || root == own.front().child + count;
  }
  /// Sorts rods by what hangs below them, so that few wait for the rod before them, whatever stands beside the tree.
  void sort_by_height(std::span<RodTree::Rod> own) {
    const auto height = [&](const RodTree::Rod& rod) { return at(rod.child).height; };
    for (const RodTree::Rod& rod : own) at(rod.parent).height = std::max(at(rod.parent).height, height(rod) + 1);
    std::ranges::stable_sort(own, {}, height);
  }

  const RodTree* tree_ = nullptr;
  std::size_t number_ = 0, most_rods_ = 0;
  std::vector<Point> points_;
  Point support_;  // any of them, below which there is nothing
};

/// Raises the levels of some pieces, which still come before those above them, to fill the lanes beside pieces that
/// nothing else of their level goes with. `first` is the number of the first piece.
void fill_lanes(std::span<Piece> pieces, std::size_t first) {
  std::size_t top = 0;
  for (const Piece& piece : pieces) top = std::max(top, piece.level);
  std::vector<std::vector<std::size_t>> of_level(top + 1), below(pieces.size());
  std::set<std::pair<std::size_t, std::size_t>> waiting;  // by size: their levels are lower, those above them are not
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    of_level[pieces[k].level].push_back(k);
    if (pieces[k].above == none) {
      waiting.emplace(pieces[k].num_rods, k);
    } else {
      below[pieces[k].above - first].push_back(k);
    }
  }
  for (std::size_t level = top + 1; level-- > 0;) {
    std::vector<std::size_t> taken;
    std::size_t most_rods = 0;
    for (const std::size_t k : of_level[level]) {
      if (waiting.erase({pieces[k].num_rods, k}) == 0) continue;  // was raised
      taken.push_back(k);
      most_rods = std::max(most_rods, pieces[k].num_rods);
    }
    while (taken.size() % num_lanes != 0) {
      const auto after = waiting.lower_bound({most_rods + 1, 0});
      if (after == waiting.begin()) break;
      taken.push_back(std::prev(after)->second);
      waiting.erase(std::prev(after));
    }
    for (const std::size_t k : taken) {
      pieces[k].level = level;
      for (const std::size_t lower : below[k]) waiting.emplace(pieces[lower].num_rods, lower);
    }
  }
}

/// Sorts pieces into groups: by level, then, among so many that follow one another, by size and shape.
class Grouping {
 public:
  Grouping(std::span<const RodTree> trees, std::size_t num_moving, Cut* cut, LanePlan* result)
      : trees_(trees),
        cut_(*cut),
        result_(*result),
        num_moving_(static_cast<Index>(num_moving)),
        joint_of_root_(num_moving, none) {}

  /// Makes a grove. Pieces that all are of the first level need no other ones, and are groves by themselves.
  void add(std::span<Piece> pieces) {
    std::ranges::stable_sort(pieces, {}, &Piece::level);
    const bool are_alone = pieces.back().level == 0;
    for (std::size_t k = 0; k < pieces.size();) {
      std::size_t end = k, num_rods = 0;
      while (end < pieces.size() && pieces[end].level == pieces[k].level && num_rods < plan::rods_of_grove)
        num_rods += pieces[end++].num_rods;
      std::ranges::stable_sort(pieces.subspan(k, end - k), [this](const Piece& a, const Piece& b) {
        return a.num_rods != b.num_rods ? a.num_rods > b.num_rods
                                        : std::ranges::lexicographical_compare(parents(a), parents(b));
      });
      for (; k < end; k += num_lanes) {
        const std::span<Piece> members = pieces.subspan(k, std::min(num_lanes, end - k));
        for (Piece& piece : are_alone ? members : std::span<Piece>()) {
          piece.island = result_.islands.size();
          result_.islands.push_back({trees_[piece.tree].first_point, trees_[piece.tree].end_point});
        }
        add_group(members);
        result_.groups.back().stands_alone = are_alone;
        if (!are_alone) continue;
        result_.end_level();
        result_.end_grove();
      }
      k = end;
      if (!are_alone && (k == pieces.size() || pieces[k].level != pieces[k - 1].level)) result_.end_level();
    }
    if (!are_alone) result_.end_grove();
  }

 private:
  std::span<const Index> parents(const Piece& piece) const {
    return std::span(cut_.parent).subspan(piece.first, piece.num_rods);
  }

  void add_group(std::span<const Piece> pieces) {
    const std::size_t num_rods = pieces.front().num_rods;
    const bool is_padded = pieces.back().num_rods < num_rods;
    LaneGroup& group = result_.add(
        {.num_rods = num_rods,
         .num_places = num_rods + (is_padded ? 2 : 1),
         .num_members = pieces.size(),
         .have_same_parents = std::ranges::all_of(
             pieces, [&](const Piece& each) { return std::ranges::equal(parents(each), parents(pieces.front())); }),
         .is_padded = is_padded},
        num_rods * packs_of_rod);
    result_.parent.resize(result_.row.size());
    for (std::size_t lane = 0; lane < num_lanes; ++lane)
      add_piece(pieces[std::min(lane, pieces.size() - 1)], lane, &group);
    group.end_joint = result_.joints.size();
    // Roots are joints of pieces that come later.
    for (std::size_t lane = 0; lane < pieces.size(); ++lane) {
      if (pieces[lane].above != none)
        joint_of_root_[static_cast<std::size_t>(pieces[lane].root)] = num_lanes * (result_.groups.size() - 1) + lane;
    }
  }

  void add_piece(const Piece& piece, std::size_t lane, LaneGroup* group) {
    const std::size_t pad = group->num_rods - piece.num_rods;
    Index* const point = result_.point.data() + num_lanes * group->first_place + lane;
    Index* const parent = result_.parent.data() + num_lanes * group->first_rod + lane;
    Index* const row = result_.row.data() + num_lanes * group->first_rod + lane;
    group->island[lane] = static_cast<Index>(piece.island);
    group->ends_tree[lane] = piece.above == none;
    for (std::size_t k = 0; k < pad; ++k) {
      row[num_lanes * k] = -1;
      parent[num_lanes * k] = static_cast<Index>(group->num_rods + 1);
      point[num_lanes * k] = ~piece.root;
    }
    if (group->is_padded) point[num_lanes * (group->num_rods + 1)] = ~piece.root;
    for (std::size_t k = pad; k <= group->num_rods; ++k) {
      const std::size_t rod = piece.first + k - pad;
      const Index own = k < group->num_rods ? cut_.rods[rod].child : piece.root;
      const bool is_own = own < num_moving_ && !note_joint(own, k, lane, *group);
      point[num_lanes * k] = is_own ? own : ~own;
      group->has_supports = group->has_supports || own >= num_moving_;
      if (k == group->num_rods) break;
      row[num_lanes * k] = cut_.rods[rod].row;
      parent[num_lanes * k] = cut_.parent[rod] + static_cast<Index>(pad);
    }
  }
  /// Notes that the point is a joint, if it is one.
  bool note_joint(Index point, std::size_t place, std::size_t lane, const LaneGroup& group) {
    const std::size_t joint = joint_of_root_[static_cast<std::size_t>(point)];
    if (joint == none) return false;
    std::size_t k = group.first_joint;
    while (k < result_.joints.size() && result_.joints[k].place != place) ++k;
    if (k == result_.joints.size()) result_.joints.push_back({place, {-1, -1, -1, -1, -1, -1, -1, -1}});
    result_.joints[k].joint[lane] = static_cast<Index>(joint);
    return true;
  }

  std::span<const RodTree> trees_;
  Cut& cut_;
  LanePlan& result_;
  Index num_moving_;
  std::vector<std::size_t> joint_of_root_;  // [point]
};

/// Cuts trees into pieces.
LanePlan cut_trees(std::span<const RodTree> trees, std::size_t num_moving) {
  LanePlan result;
  result.program = Program::Trees;
  Cut cut;
  Grouping grouping(trees, num_moving, &cut, &result);
  for (std::size_t tree = 0; tree < trees.size();) {
    const std::size_t first = cut.pieces.size(), most_rods = result.num_rods + plan::rods_of_grove;
    const bool are_small = trees[tree].is_small();
    for (; tree < trees.size() && trees[tree].is_small() == are_small && result.num_rods < most_rods; ++tree) {
      cut.add(trees[tree], tree);
      if (!are_small) result.islands.push_back({trees[tree].first_point, trees[tree].end_point});
      result.num_rods += trees[tree].rods.size();
    }
    const std::span<Piece> pieces = std::span(cut.pieces).subspan(first);
    fill_lanes(pieces, first);
    grouping.add(pieces);
  }
  return result;
}

}  // namespace

LanePlan take_trees(const RodRows& rods, const Numbering& numbering, bool eagerly, std::vector<Index>* islands) {
  const auto is_full = [&](const std::vector<RodTree>& some) {
    return eagerly || cut_trees(some, numbering.num_moving).fullness() >= plan::fullness_of_trees;
  };
  std::vector<RodTree> small, trees;
  for (const Index island : *islands) {
    if (std::optional<RodTree> tree = read_tree(rods, numbering, island))
      (tree->is_small() ? small : trees).push_back(*std::move(tree));
  }
  std::erase_if(trees, [&](const RodTree& tree) { return !is_full({tree}); });
  std::ranges::stable_sort(small, {}, [](const RodTree& tree) { return tree.rods.size(); });
  if (is_full(small)) trees.insert(trees.end(), small.begin(), small.end());
  std::ranges::sort(trees, {}, [](const RodTree& tree) { return std::pair(!tree.is_small(), tree.first_point); });
  std::vector<char> is_taken(numbering.num_islands(), 0);
  for (const RodTree& tree : trees) is_taken[static_cast<std::size_t>(tree.island)] = 1;
  std::erase_if(*islands, [&](Index island) { return is_taken[static_cast<std::size_t>(island)] != 0; });
  LanePlan result = cut_trees(trees, numbering.num_moving);
  constexpr double flops_a_rod = 50.0;
  const std::size_t count = trees.size(), nonzeros = packs_of_rod * result.num_rods;
  result.factor = {count, nonzeros, nonzeros, flops_a_rod * static_cast<double>(result.num_rods)};
  result.reason = (count == 1 ? "one tree" : std::to_string(count) + " trees") + " of rods, which use " +
                  std::to_string(static_cast<int>(100.0 * result.fullness())) + " % of the lanes";
  return result;
}

}  // namespace tanor::detail
