#include "system/numbering.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

#include "system/contacts.hpp"
#include "system/members.hpp"

namespace tanor {

namespace {

/// Lists, one after the other: list k is [start[k], start[k + 1]).
template <class Entry>
struct Lists {
  std::vector<Index> start{0};
  std::vector<Entry> entries;

  std::span<const Entry> operator[](Index k) const {
    return {entries.data() + start[k], static_cast<std::size_t>(start[k + 1] - start[k])};
  }
  std::size_t size() const { return start.size() - 1; }
  void end_list() { start.push_back(static_cast<Index>(entries.size())); }
  void clear() {
    start.assign(1, 0);
    entries.clear();
  }
};

/// A member at one of its points, and the other one where it joins two: -1 where it joins more or none.
struct Joint {
  Index member, other;
};

Lists<Joint> list_joints(const Lists<Index>& points_of_member, std::size_t num_points) {
  Lists<Joint> result;
  result.start.assign(num_points + 1, 0);
  for (const Index point : points_of_member.entries) ++result.start[point + 1];
  std::partial_sum(result.start.begin(), result.start.end(), result.start.begin());
  result.entries.resize(points_of_member.entries.size());
  std::vector<Index> next(result.start.begin(), result.start.end() - 1);
  for (std::size_t k = 0; k < points_of_member.size(); ++k) {
    const auto member = static_cast<Index>(k);
    const std::span<const Index> points = points_of_member[member];
    for (const Index point : points)
      result.entries[next[point]++] = {member, points.size() == 2 ? points[0] + points[1] - point : -1};
  }
  return result;
}

/// What constraints connect, by numbers of its own: points and members as a search from one of its points finds them.
/// However the user numbers them, neighbours are near each other in memory here.
struct Island {
  std::vector<Index> points, members;  // the user's
  Lists<Index> points_of_member, members_of_point;

  void clear() {
    points.clear();
    members.clear();
    points_of_member.clear();
    members_of_point.clear();
  }
};

/// Every point is joined to two others, by members of two points.
bool is_ring(const Island& island) {
  const auto are_pairs = [](const Lists<Index>& lists) {
    for (std::size_t k = 0; k < lists.size(); ++k) {
      if (lists[static_cast<Index>(k)].size() != 2) return false;
    }
    return true;
  };
  return island.points.size() > 2 && are_pairs(island.members_of_point) && are_pairs(island.points_of_member);
}

/// Finds islands one after the other, each once.
class Islands {
 public:
  Islands(const Lists<Index>& points_of_member, const Lists<Joint>& joints_of_point)
      : points_of_member_(points_of_member),
        joints_of_point_(joints_of_point),
        point_name_(joints_of_point.size(), -1),
        member_name_(points_of_member.size(), -1) {}

  bool have(Index point) const { return point_name_[point] >= 0; }

  /// That of `root`, whose points are in the order of their distance from it. Until the next call.
  const Island& find(Index root) {
    island_.clear();
    name_point(root);
    for (std::size_t head = 0; head < island_.points.size(); ++head) {
      for (const auto& [member, other] : joints_of_point_[island_.points[head]]) {
        if (member_name_[member] < 0) name_member(member, static_cast<Index>(head), other);
        island_.members_of_point.entries.push_back(member_name_[member]);
      }
      island_.members_of_point.end_list();
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
    if (other >= 0) {  // one look into a long list less
      points.insert(points.end(), {head, name_point(other)});
    } else {
      for (const Index point : points_of_member_[member]) points.push_back(name_point(point));
    }
    island_.points_of_member.end_list();
  }

  const Lists<Index>& points_of_member_;
  const Lists<Joint>& joints_of_point_;
  std::vector<Index> point_name_, member_name_;  // in their island; -1: not found so far
  Island island_;
};

/// Breadth-first searches over an island.
class Search {
 public:
  /// The island's points in the order of their distance from `root`.
  const std::vector<Index>& visit(const Island& island, Index root) {
    point_seen_.assign(island.points.size(), 0);
    member_seen_.assign(island.members.size(), 0);
    order_.assign(1, root);
    point_seen_[root] = 1;
    for (std::size_t head = 0; head < order_.size(); ++head) {
      for (const Index member : island.members_of_point[order_[head]]) {
        if (std::exchange(member_seen_[member], 1) != 0) continue;
        for (const Index point : island.points_of_member[member]) {
          if (std::exchange(point_seen_[point], 1) == 0) order_.push_back(point);
        }
      }
    }
    return order_;
  }

 private:
  std::vector<char> point_seen_, member_seen_;
  std::vector<Index> order_;
};

/// Points that are islands by themselves, in the user's order but for this: those with the same kinds of constraints
/// follow one another.
std::vector<Index> list_lone_points(const System& system, const Lists<Index>& points_of_member,
                                    const Lists<Joint>& joints_of_point) {
  std::vector<std::uint64_t> kind_of_member;
  for (const Constraint& constraint : system.constraints) {
    const std::size_t count = std::visit([](const auto& group) { return num_members(group); }, constraint);
    kind_of_member.insert(kind_of_member.end(), count, constraint.index() + 1);
  }
  kind_of_member.resize(points_of_member.size(), 0);  // those of contacts
  std::vector<std::pair<std::uint64_t, Index>> points;
  for (std::size_t point = 0; point < joints_of_point.size(); ++point) {
    const std::span<const Joint> joints = joints_of_point[static_cast<Index>(point)];
    const auto is_alone = [&](const Joint& joint) {
      return joint.other < 0 && points_of_member[joint.member].size() == 1;
    };
    if (joints.empty() || !std::all_of(joints.begin(), joints.end(), is_alone)) continue;
    std::uint64_t kinds = 0;
    for (const Joint& joint : joints) kinds = kinds << 4 | kind_of_member[static_cast<std::size_t>(joint.member)];
    points.emplace_back(kinds, static_cast<Index>(point));
  }
  std::stable_sort(points.begin(), points.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Index> result;
  for (const auto& [kinds, point] : points) result.push_back(point);
  return result;
}

}  // namespace

Numbering number(const System& system) {
  const std::size_t num_points = system.num_points();
  std::vector<char> is_support(num_points, 0);
  for (const Support& support : system.supports) {
    for (const Index point : support.points) is_support[point] = 1;
  }

  // Members and the moving points that they join.
  Lists<Index> points_of_member;
  std::vector<Index> user_first_row{0};  // of each member, and the number of rows
  const auto add_member = [&](std::span<const Index> points, int rows) {
    for (const Index point : points) {
      if (!is_support[point]) points_of_member.entries.push_back(point);
    }
    points_of_member.end_list();
    user_first_row.push_back(user_first_row.back() + rows);
  };
  for_each_member(system, add_member);
  Numbering result;
  result.num_user_rows = static_cast<std::size_t>(user_first_row.back());
  for (const Contact& contact : list_contacts(system)) {
    if (contact.can_stick) add_member({&contact.point, 1}, contact.num_tangents());
  }
  const Lists<Joint> joints_of_point = list_joints(points_of_member, num_points);
  const std::size_t num_members = points_of_member.size();

  result.user_point.reserve(num_points);
  result.inner_point.assign(num_points, -1);
  result.user_row.reserve(user_first_row.back());
  result.member_row.assign(num_members, -1);
  result.island_start.push_back(0);
  const auto append_point = [&](Index point) {
    result.inner_point[point] = static_cast<Index>(result.user_point.size());
    result.user_point.push_back(point);
  };

  const auto append_member = [&](Index member) {
    result.member_row[member] = static_cast<Index>(result.user_row.size());
    for (Index row = user_first_row[member]; row < user_first_row[member + 1]; ++row) result.user_row.push_back(row);
  };

  // Round a ring, the member between two points after the first one of them.
  const auto append_ring = [&](const Island& island) {
    const auto other = [](std::span<const Index> pair, Index one) { return pair[0] == one ? pair[1] : pair[0]; };
    Index point = 0, member = island.members_of_point[0][0];
    for (std::size_t k = 0; k < island.points.size(); ++k) {
      append_point(island.points[point]);
      append_member(island.members[member]);
      point = other(island.points_of_member[member], point);
      member = other(island.members_of_point[point], member);
    }
  };

  // Others from a far end (two searches find one), then backwards: what lies farthest comes first.
  Search search;
  std::vector<char> is_numbered;  // [member of the island]
  const auto append_from_far_end = [&](const Island& island) {
    const Index far_end = search.visit(island, static_cast<Index>(island.points.size()) - 1).back();
    const std::vector<Index>& order = search.visit(island, far_end);
    is_numbered.assign(island.members.size(), 0);
    for (auto point = order.rbegin(); point != order.rend(); ++point) {
      append_point(island.points[*point]);
      // A member is numbered with the first of its points: in a tree that is the rod towards the root. Those of this
      // point alone come first, so that a path which begins at a support runs along.
      for (const bool alone : {true, false}) {
        for (const Index member : island.members_of_point[*point]) {
          if ((island.points_of_member[member].size() == 1) != alone) continue;
          if (std::exchange(is_numbered[member], 1) == 0) append_member(island.members[member]);
        }
      }
    }
  };

  Islands islands(points_of_member, joints_of_point);
  std::vector<char> is_alone(num_points, 0);
  const std::vector<Index> lone_points = list_lone_points(system, points_of_member, joints_of_point);
  for (const Index point : lone_points) is_alone[point] = 1;
  auto next_alone = lone_points.begin();
  for (std::size_t place = 0; place < num_points; ++place) {
    const Index root = is_alone[place] ? *next_alone++ : static_cast<Index>(place);
    if (islands.have(root) || is_support[root] || joints_of_point[root].empty()) continue;
    const Island& island = islands.find(root);
    is_ring(island) ? append_ring(island) : append_from_far_end(island);
    result.island_start.push_back(static_cast<Index>(result.user_row.size()));
  }

  for (std::size_t member = 0; member < num_members; ++member) {
    if (result.member_row[member] < 0) append_member(static_cast<Index>(member));
  }
  for (std::size_t point = 0; point < num_points; ++point) {
    if (!islands.have(static_cast<Index>(point)) && !is_support[point]) append_point(static_cast<Index>(point));
  }
  result.num_moving = result.user_point.size();
  for (std::size_t point = 0; point < num_points; ++point) {
    if (is_support[point]) append_point(static_cast<Index>(point));
  }
  return result;
}

void Numbering::gather_points(std::span<const double> user, std::span<double> inner, std::size_t width) const {
  for (std::size_t i = 0; i < user_point.size(); ++i) {
    for (std::size_t k = 0; k < width; ++k) inner[width * i + k] = user[width * user_point[i] + k];
  }
}

void Numbering::scatter_points(std::span<const double> inner, std::span<double> user, std::size_t width) const {
  for (std::size_t i = 0; i < user_point.size(); ++i) {
    for (std::size_t k = 0; k < width; ++k) user[width * user_point[i] + k] = inner[width * i + k];
  }
}

void Numbering::scatter_rows(std::span<const double> inner, std::span<double> user) const {
  for (std::size_t a = 0; a < user_row.size(); ++a) {
    if (!is_contact_row(a)) user[user_row[a]] = inner[a];
  }
}

}  // namespace tanor
