#include "system/numbering.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "base/groups.hpp"
#include "base/scattered.hpp"
#include "base/vec3.hpp"
#include "system/contacts.hpp"
#include "system/members.hpp"
#include "system/tree_order.hpp"

namespace tanor::detail {

namespace {

/// A member at one of its points. `other` is the other point if the member joins two, and -1 if it joins more or only
/// one.
struct Joint {
  Index member, other;
};

Groups<Joint> list_joints(const Groups<Index>& points_of_member, std::size_t num_points) {
  return {num_points, [&](const auto& add) {
            for (std::size_t k = 0; k < points_of_member.size(); ++k) {
              const std::span<const Index> points = points_of_member[k];
              for (const Index point : points)
                add(point, Joint{static_cast<Index>(k), points.size() == 2 ? points[0] + points[1] - point : -1});
            }
          }};
}

/// Points that constraints connect, with numbers of their own, in the order in which a search from one of its points
/// finds points and members. However the user numbers them, neighbours are near each other in memory here.
struct Island {
  std::vector<Index> points, members;  // numbers of the user
  Groups<Index> points_of_member, members_of_point;

  void clear() {
    points.clear();
    members.clear();
    points_of_member.clear();
    members_of_point.clear();
  }
};

/// True if every point is joined to two others, by members of two points.
bool is_ring(const Island& island) {
  const auto are_pairs = [](const Groups<Index>& groups) {
    for (std::size_t k = 0; k < groups.size(); ++k) {
      if (groups[k].size() != 2) return false;
    }
    return true;
  };
  return island.points.size() > 2 && are_pairs(island.members_of_point) && are_pairs(island.points_of_member);
}

/// True if there are no rings. Constraints of single points may be there, too.
bool is_tree(const Island& island) {
  std::size_t joints = 0;
  for (std::size_t member = 0; member < island.points_of_member.size(); ++member) {
    if (island.points_of_member[member].size() > 2) return false;
    joints += island.points_of_member[member].size() == 2 ? 1 : 0;
  }
  return joints + 1 == island.points.size();
}

/// True if the points of a tree follow one another, each joined to the next.
bool is_path(const Island& tree) {
  const auto joins_two = [&](Index member) { return tree.points_of_member[member].size() == 2; };
  for (std::size_t point = 0; point < tree.points.size(); ++point) {
    if (std::ranges::count_if(tree.members_of_point[point], joins_two) > 2) return false;
  }
  return true;
}

/// Finds islands one after the other, each once.
class Islands {
 public:
  Islands(const Groups<Index>& points_of_member, const Groups<Joint>& joints_of_point)
      : points_of_member_(points_of_member),
        joints_of_point_(joints_of_point),
        point_name_(joints_of_point.size(), -1),
        member_name_(points_of_member.size(), -1) {
    // Reserved memory that nobody touches costs nothing, while arrays that grow are moved again and again.
    island_.points.reserve(point_name_.size());
    island_.members.reserve(member_name_.size());
    island_.points_of_member.start.reserve(member_name_.size() + 1);
    island_.points_of_member.entries.reserve(points_of_member.entries.size());
    island_.members_of_point.start.reserve(point_name_.size() + 1);
    island_.members_of_point.entries.reserve(points_of_member.entries.size());
  }

  bool have(Index point) const { return point_name_[point] >= 0; }

  /// Returns the island of `root`, with points in the order of their distance from it. It is valid until the next call.
  const Island& find(Index root) {
    island_.clear();
    name_point(root);
    for (std::size_t head = 0; head < island_.points.size(); ++head) {
      for (const auto& [member, other] : joints_of_point_[island_.points[head]]) {
        if (member_name_[member] < 0) name_member(member, static_cast<Index>(head), other);
        island_.members_of_point.entries.push_back(member_name_[member]);
      }
      island_.members_of_point.end_group();
    }
    return island_;
  }

 private:
  Index name_point(Index point) {
    Index& name = point_name_[point];
    if (name < 0) {
      name = static_cast<Index>(island_.points.size());
      island_.points.push_back(point);
    }
    return name;
  }
  void name_member(Index member, Index head, Index other) {
    member_name_[member] = static_cast<Index>(island_.members.size());
    island_.members.push_back(member);
    std::vector<Index>& points = island_.points_of_member.entries;
    if (other >= 0) {  // saves one look into a long list
      points.insert(points.end(), {head, name_point(other)});
    } else {
      for (const Index point : points_of_member_[member]) points.push_back(name_point(point));
    }
    island_.points_of_member.end_group();
  }

  const Groups<Index>& points_of_member_;
  const Groups<Joint>& joints_of_point_;
  std::vector<Index> point_name_, member_name_;  // numbers in their island; -1 if not found so far
  Island island_;
};

/// Lists the points that are islands by themselves. Those with the same kinds of constraints follow one another;
/// otherwise they are in the user's order.
std::vector<Index> list_lone_points(const System& system, const Groups<Index>& points_of_member,
                                    const Groups<Joint>& joints_of_point) {
  // Points are distinguished by the kinds of their last eight constraints.
  constexpr int bits = 8;
  static_assert(std::variant_size_v<Constraint> < (1u << bits), "the number of a kind fits its bits");
  std::vector<std::uint64_t> kind_of_member;
  for (const Constraint& constraint : system.constraints) {
    const std::size_t count = std::visit([](const auto& group) { return num_members(group); }, constraint);
    kind_of_member.insert(kind_of_member.end(), count, constraint.index() + 1);
  }
  kind_of_member.resize(points_of_member.size(), 0);  // members of contacts
  std::vector<std::pair<std::uint64_t, Index>> points;
  for (std::size_t point = 0; point < joints_of_point.size(); ++point) {
    const std::span<const Joint> joints = joints_of_point[static_cast<Index>(point)];
    const auto is_alone = [&](const Joint& joint) {
      return joint.other < 0 && points_of_member[joint.member].size() == 1;
    };
    if (joints.empty() || !std::all_of(joints.begin(), joints.end(), is_alone)) continue;
    std::uint64_t kinds = 0;
    for (const Joint& joint : joints) kinds = kinds << bits | kind_of_member[static_cast<std::size_t>(joint.member)];
    points.emplace_back(kinds, static_cast<Index>(point));
  }
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Index> result;
  for (const auto& [kinds, point] : points) result.push_back(point);
  return result;
}

/// Appends points and members to a numbering, island by island, in an order that is good for elimination.
class NumberingBuilder {
 public:
  explicit NumberingBuilder(const System& system) : is_support_(find_supports(system)) {
    list_members(system);
    result_.user_point.reserve(system.num_points());
    result_.inner_point.assign(system.num_points(), -1);
    result_.user_row.reserve(user_first_row_.back());
    result_.member_row.assign(points_of_member_.size(), -1);
    result_.island_start.push_back(0);
  }

  Numbering build(const System& system) {
    const std::size_t num_points = is_support_.size();
    const Groups<Joint> joints_of_point = list_joints(points_of_member_, num_points);
    Islands islands(points_of_member_, joints_of_point);
    std::vector<char> is_alone(num_points, 0);
    const std::vector<Index> lone_points = list_lone_points(system, points_of_member_, joints_of_point);
    for (const Index point : lone_points) is_alone[point] = 1;
    auto next_alone = lone_points.begin();
    for (std::size_t place = 0; place < num_points; ++place) {
      const Index root = is_alone[place] ? *next_alone++ : static_cast<Index>(place);
      if (islands.have(root) || is_support_[root] || joints_of_point[root].empty()) continue;
      const Island& island = islands.find(root);
      append_island(island);
      result_.island_start.push_back(static_cast<Index>(result_.user_row.size()));
    }
    append_what_is_left(islands);
    list_one_sided(system);
    result_.is_natural = std::ranges::is_sorted(result_.user_point);
    return std::move(result_);
  }

 private:
  /// Lists the members and the moving points that each of them joins; rows of contacts come after those of the user.
  void list_members(const System& system) {
    std::size_t num_members = 0, num_entries = 0;
    for_each_member(system, [&](std::span<const Index> points, int) {
      ++num_members;
      num_entries += points.size();
    });
    points_of_member_.start.reserve(num_members + 1);
    points_of_member_.entries.reserve(num_entries);
    user_first_row_.reserve(num_members + 1);
    const auto add_member = [&](std::span<const Index> points, int rows) {
      for (const Index point : points) {
        if (!is_support_[point]) points_of_member_.entries.push_back(point);
      }
      points_of_member_.end_group();
      user_first_row_.push_back(user_first_row_.back() + rows);
    };
    for_each_member(system, add_member);
    result_.num_user_rows = static_cast<std::size_t>(user_first_row_.back());
    for (const Contact& contact : list_contacts(system)) {
      if (contact.can_stick) add_member({&contact.point, 1}, contact.num_tangents());
    }
  }

  void list_one_sided(const System& system) {
    std::size_t member = 0;
    for (const Constraint& constraint : system.constraints) {
      std::visit(
          [&](const auto& group) {
            const std::size_t first = member;
            member += num_members(group);
            if constexpr (requires { group.side; }) {
              if (!group.side) return;
              result_.may_open.resize(result_.num_rows(), 0);
              for (std::size_t k = first; k < member; ++k) {
                const Index row = result_.member_row[k];
                if (row >= result_.island_start.back()) continue;  // it joins supports alone
                result_.one_sided.push_back({row, *group.side == OneSide::AtLeast ? 1.0 : -1.0, group.restitution});
                result_.may_open[static_cast<std::size_t>(row)] = 1;
              }
            }
          },
          constraint);
    }
    std::ranges::sort(result_.one_sided, {}, &OneSidedRow::row);
  }

  void append_point(Index point) {
    result_.inner_point[point] = static_cast<Index>(result_.user_point.size());
    result_.user_point.push_back(point);
  }

  void append_member(Index member) {
    result_.member_row[member] = static_cast<Index>(result_.user_row.size());
    for (Index row = user_first_row_[member]; row < user_first_row_[member + 1]; ++row) result_.user_row.push_back(row);
  }

  void append_island(const Island& island) {
    if (is_ring(island)) return append_ring(island);
    if (!is_tree(island)) return append_from_far_end(island, false);
    if (is_path(island)) return append_from_far_end(island, true);
    append_points(island, TreeOrder(island.points_of_member, island.members_of_point).list());
  }

  /// Appends a ring all round; the member between two points follows the first one of them.
  void append_ring(const Island& island) {
    const auto other = [](std::span<const Index> pair, Index one) { return pair[0] == one ? pair[1] : pair[0]; };
    Index point = 0, member = island.members_of_point[0][0];
    for (std::size_t k = 0; k < island.points.size(); ++k) {
      append_point(island.points[point]);
      append_member(island.members[member]);
      point = other(island.points_of_member[member], point);
      member = other(island.members_of_point[point], member);
    }
  }

  /// Appends an island backwards from a far end, which two searches find, so that what lies farthest comes first. For a
  /// path it is the end with the larger numbers, so that a chain keeps the user's direction.
  void append_from_far_end(const Island& island, bool is_path) {
    const auto end = static_cast<Index>(island.points.size()) - 1;  // far from the root
    const auto visit = [&](Index root) {
      return search_.visit(island.points_of_member, island.members_of_point, root);
    };
    std::vector<Index> order = visit(end);
    if (!is_path || !ends_with_larger_numbers(island, order)) order = visit(order.back());
    std::ranges::reverse(order);
    append_points(island, order);
  }

  /// Returns true if a path, backwards, ends with its larger numbers: of the points if these count up or down along it,
  /// else of the members, which lists mostly name in the order of a chain.
  static bool ends_with_larger_numbers(const Island& island, const std::vector<Index>& path) {
    const auto point = [&](Index local) { return island.points[local]; };
    const bool counts_down = std::ranges::is_sorted(path, std::ranges::greater(), point);
    if (counts_down || std::ranges::is_sorted(path, {}, point)) return counts_down;
    const auto rod = [&](Index local) {
      return *std::ranges::find_if(island.members_of_point[local],
                                   [&](Index member) { return island.points_of_member[member].size() > 1; });
    };
    return island.members[rod(path.front())] > island.members[rod(path.back())];
  }

  /// Appends points in this order. A member is numbered with the first of its points; in a tree that is the rod towards
  /// the root. Members of this point alone come first, so that a path which begins at a support runs along.
  void append_points(const Island& island, const std::vector<Index>& order) {
    is_numbered_.assign(island.members.size(), 0);
    for (const Index point : order) {
      append_point(island.points[point]);
      for (const bool alone : {true, false}) {
        for (const Index member : island.members_of_point[point]) {
          if ((island.points_of_member[member].size() == 1) != alone) continue;
          if (std::exchange(is_numbered_[member], 1) == 0) append_member(island.members[member]);
        }
      }
    }
  }

  /// Appends members that join supports alone, moving points without constraints, and the supports, in this order.
  void append_what_is_left(const Islands& islands) {
    for (std::size_t member = 0; member < points_of_member_.size(); ++member) {
      if (result_.member_row[member] < 0) append_member(static_cast<Index>(member));
    }
    for (std::size_t point = 0; point < is_support_.size(); ++point) {
      if (!islands.have(static_cast<Index>(point)) && !is_support_[point]) append_point(static_cast<Index>(point));
    }
    result_.num_moving = result_.user_point.size();
    for (std::size_t point = 0; point < is_support_.size(); ++point) {
      if (is_support_[point]) append_point(static_cast<Index>(point));
    }
  }

  std::vector<char> is_support_;          // [point]
  Groups<Index> points_of_member_;        // moving points only
  std::vector<Index> user_first_row_{0};  // first row of each member, and then the number of rows
  BreadthFirstSearch search_;
  std::vector<char> is_numbered_;  // [member of the island at hand]
  Numbering result_;
};

}  // namespace

Numbering number(const System& system) {
  return NumberingBuilder(system).build(system);
}

void Numbering::gather_points(std::span<const double> user, std::span<double> inner, const Parallel& by) const {
  by.for_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
    if (is_natural) {
      std::copy_n(user.data() + 3 * begin, 3 * (end - begin), inner.data() + 3 * begin);
      return;
    }
    visit_points(user.data(), begin, end,
                 [&](std::size_t i, const double* point) { store(inner.data(), i, load(point, 0)); });
  });
}

void Numbering::scatter_points(std::span<const double> inner, std::span<double> user, const Parallel& by) const {
  by.for_ranges(num_points(), [&](std::size_t begin, std::size_t end) {
    if (is_natural) {
      std::copy_n(inner.data() + 3 * begin, 3 * (end - begin), user.data() + 3 * begin);
      return;
    }
    visit_points(user.data(), begin, end,
                 [&](std::size_t i, double* point) { store(point, 0, load(inner.data(), i)); });
  });
}

/// Calls visit(inner point, its place in the user's array) for the inner points [begin, end).
template <class Number, class Visit>
void Numbering::visit_points(Number* user, std::size_t begin, std::size_t end, const Visit& visit) const {
  const auto place = [&](std::size_t i) { return user + 3 * static_cast<std::size_t>(user_point[i]); };
  visit_scattered(begin, end, num_points(), 3 * sizeof(double), place, [&](std::size_t i) { visit(i, place(i)); });
}

void Numbering::scatter_rows(std::span<const double> inner, std::span<double> user, const Parallel& by) const {
  by.for_ranges(num_rows(), [&](std::size_t begin, std::size_t end) {
    for (std::size_t a = begin; a < end; ++a) {
      if (!is_contact_row(a)) user[user_row[a]] = inner[a];
    }
  });
}

}  // namespace tanor::detail
