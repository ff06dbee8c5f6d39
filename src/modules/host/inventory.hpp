#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "system/members.hpp"

namespace tanor::detail {

/// Calls visit(&point) for the points of all members, in turn.
template <class Visit>
void for_each_point(Constraint* constraint, const Visit& visit) {
  std::visit(
      [&]<class Kind>(Kind& group) {
        for (auto& member : group.*KindOf<Kind>::members) {
          if constexpr (has_single_points<Kind>)
            visit(&member);
          else
            for (Index& point : member) visit(&point);
        }
      },
      *constraint);
}

/// The constraints of a host, one by one. Ids ascend in the order in which constraints came, and none is given twice.
/// Rows are numbered in the order of ids. Points have numbers that never change (see HostPoints).
class Inventory {
 public:
  /// Adds a group whose parameters are numbers, none "initial". `images` [member] is empty, or as Periodicity has them.
  /// Returns the id of the first member; the others follow.
  ConstraintId add(Constraint group, std::vector<std::array<int, 3>> images);
  /// Removes constraints. Each id exists and is given once.
  void remove(std::span<const ConstraintId> ids);
  /// Sets a length (radius, offset, cosine) and its rate of change, which have passed `check_length`. Returns true if
  /// every call reads it from now on; if false, the constraint has to be planned anew.
  bool set_length(ConstraintId id, double length, double rate);
  /// Throws InputError if there is no such constraint, its kind has no length, or a number is out of range.
  void check_length(ConstraintId id, double length, double rate) const;
  /// Replaces each point by number_of(point).
  template <class NumberOf>
  void rename_points(const NumberOf& number_of) {
    for (Group& group : groups_) for_each_point(&group.all, [&](Index* point) { *point = number_of(*point); });
  }

  bool has(ConstraintId id) const {
    return id >= 0 && id < static_cast<ConstraintId>(group_of_.size()) && group_of_[static_cast<std::size_t>(id)] >= 0;
  }
  /// Throws InputError if there is no constraint with this id.
  void require(ConstraintId id) const;
  /// Returns the id of the next constraint; all ids given so far are below it.
  ConstraintId next_id() const { return static_cast<ConstraintId>(group_of_.size()); }
  /// Returns the number of the constraint's group, also for an id that was removed.
  std::size_t group_number(ConstraintId id) const {
    const Index number = group_of_[static_cast<std::size_t>(id)];
    return static_cast<std::size_t>(number < 0 ? ~number : number);
  }
  const std::string& group_name(std::size_t group) const { return groups_[group].name; }
  std::size_t num_groups() const { return groups_.size(); }
  /// Returns how many members were added, 0 if none of them is left.
  std::size_t group_size(std::size_t group) const { return shape_of(groups_[group].all).members; }
  /// Returns the constraint's place in the group that was added.
  std::size_t member_number(ConstraintId id) const { return static_cast<std::size_t>(id - group_of(id).first); }
  /// Returns a name such as "rods[17]", by the place in the group that was added.
  std::string member_name(ConstraintId id) const;
  bool has_name(const std::string& name) const { return names_.contains(name); }
  bool has_images() const { return has_images_; }
  std::span<const Index> points(ConstraintId id) const;
  std::size_t kind(ConstraintId id) const { return group_of(id).shell.index(); }
  /// Returns the number of rows, also for an id that was removed.
  std::size_t num_rows(ConstraintId id) const { return shape_of(group_of(id).shell).rows_per_member; }

  // ---- rows ----

  std::size_t num_rows() const { return static_cast<std::size_t>(first_row_.back()); }
  std::size_t first_row(ConstraintId id) const {
    return static_cast<std::size_t>(first_row_[static_cast<std::size_t>(id)]);
  }
  ConstraintId id_of_row(std::size_t row) const;
  /// Returns a name such as "rods[17]" or "wire[4].1".
  std::string row_name(std::size_t row) const;
  /// Returns the name of a group inside a part, which may hold only some of its members.
  static std::string part_name(std::size_t group);
  /// Returns the text of a part, whose constraints are `members`, with the host's names in it. "\x1f3[5]" becomes the
  /// name of member 5, counted from 0, of group 3 in this part.
  std::string with_host_names(std::span<const ConstraintId> members, const std::string& text) const;

  // ---- members together ----

  /// Returns the constraints with these ids, which ascend, on the points number_of(point).
  template <class NumberOf>
  std::vector<Constraint> take(std::span<const ConstraintId> ids, const NumberOf& number_of) const {
    std::vector<Constraint> result;
    bool drives_rods = false;
    for_each_run(ids, [&](const Group& group, const std::vector<Index>& numbers) {
      result.push_back(pick(group, numbers));
      drives_rods = drives_rods || drives_some(group, numbers);
      for_each_point(&result.back(), [&](Index* point) { *point = number_of(*point); });
    });
    if (drives_rods) std::ranges::for_each(result, let_move);
    return result;
  }
  /// Returns the images of the rows of these constraints.
  std::vector<std::array<int, 3>> take_images(std::span<const ConstraintId> ids) const;

 private:
  struct DrivenLength {
    double length, rate;
  };
  struct Group {
    Constraint all, shell;  // with all members and with none
    ConstraintId first;
    std::size_t num_left;
    std::string name;
    std::vector<std::array<int, 3>> images;               // [member] or empty
    std::vector<std::shared_ptr<DrivenLength>> driven{};  // [member] or empty
  };

  const Group& group_of(ConstraintId id) const { return groups_[group_number(id)]; }
  /// Calls visit(group, numbers of members) for each run of ids of one group.
  template <class Visit>
  void for_each_run(std::span<const ConstraintId> ids, const Visit& visit) const {
    for (std::size_t k = 0; k < ids.size();) {
      const Group& group = group_of(ids[k]);
      std::vector<Index> numbers;
      for (; k < ids.size() && &group_of(ids[k]) == &group; ++k)
        numbers.push_back(static_cast<Index>(ids[k] - group.first));
      visit(group, numbers);
    }
  }
  static Constraint pick(const Group& group, const std::vector<Index>& numbers);
  static bool drives_some(const Group& group, const std::vector<Index>& numbers);
  static void let_move(Constraint& constraint);
  static void drive(Group* group, std::size_t number);
  void number_rows(ConstraintId from);

  std::vector<Group> groups_;    // a group without a member left is empty
  std::vector<Index> group_of_;  // [id] number of its group; the complement if removed
  std::set<std::string> names_;
  bool has_images_ = false;
  std::vector<Index> first_row_{0};  // [id] and then the number of rows; removed ids have no rows
};

}  // namespace tanor::detail
