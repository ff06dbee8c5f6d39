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

namespace tanor {

/// The constraints of a host, one by one. Ids ascend in the order in which constraints came, and none is given twice;
/// rows are numbered in the order of ids. Points are numbers that never change (see Points).
class Inventory {
 public:
  /// A group whose numbers are known: none is "initial". `images` [member]: empty, or as Periodicity has them. Returns
  /// the id of the first member, which the others follow.
  ConstraintId add(Constraint group, std::vector<std::array<int, 3>> images);
  /// Each id is there, once.
  void remove(std::span<const ConstraintId> ids);
  /// A length (radius, offset, cosine) and how fast it changes. Returns whether it is read in every call from now on;
  /// else the constraint has to be planned anew. Throws InputError where the kind has none, or where it is out of
  /// range.
  bool set_length(ConstraintId id, double length, double rate);
  /// What `set_length` would complain about.
  void check_length(ConstraintId id, double length, double rate) const;
  /// Points := number_of(point).
  template <class NumberOf>
  void rename_points(const NumberOf& number_of) {
    for (Group& group : groups_) for_each_point(&group.all, [&](Index* point) { *point = number_of(*point); });
  }

  bool has(ConstraintId id) const {
    return id >= 0 && id < static_cast<ConstraintId>(group_of_.size()) && group_of_[static_cast<std::size_t>(id)] >= 0;
  }
  /// Throws InputError where there is none.
  void require(ConstraintId id) const;
  /// The ids that were given so far are below it.
  ConstraintId next_id() const { return static_cast<ConstraintId>(group_of_.size()); }
  /// Also of an id that was removed.
  std::size_t group_number(ConstraintId id) const {
    const Index number = group_of_[static_cast<std::size_t>(id)];
    return static_cast<std::size_t>(number < 0 ? ~number : number);
  }
  const std::string& group_name(std::size_t group) const { return groups_[group].name; }
  /// "rods[17]": by its place in the group that was added.
  std::string member_name(ConstraintId id) const;
  bool has_name(const std::string& name) const { return names_.contains(name); }
  bool has_images() const { return has_images_; }
  std::span<const Index> points(ConstraintId id) const;
  std::size_t kind(ConstraintId id) const { return group_of(id).shell.index(); }
  /// Also of an id that was removed.
  std::size_t num_rows(ConstraintId id) const { return shape_of(group_of(id).shell).rows_per_member; }

  // ---- rows ----

  std::size_t num_rows() const { return static_cast<std::size_t>(first_row_.back()); }
  std::size_t first_row(ConstraintId id) const {
    return static_cast<std::size_t>(first_row_[static_cast<std::size_t>(id)]);
  }
  ConstraintId id_of_row(std::size_t row) const;
  /// "rods[17]", "wire[4].1"
  std::string row_name(std::size_t row) const;

  // ---- members together ----

  /// The constraints with these ids, which ascend, on the points number_of(point).
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
  /// Returns the images of their rows.
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
  /// visit(group, numbers of members) for each run of ids of one group.
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
  template <class Visit>
  static void for_each_point(Constraint* constraint, const Visit& visit) {
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
  static Constraint pick(const Group& group, const std::vector<Index>& numbers);
  static bool drives_some(const Group& group, const std::vector<Index>& numbers);
  static void let_move(Constraint& constraint);
  static void drive(Group* group, std::size_t number);
  void number_rows(ConstraintId from);

  std::vector<Group> groups_;    // those without a member left are empty
  std::vector<Index> group_of_;  // [id] its complement: removed
  std::set<std::string> names_;
  bool has_images_ = false;
  std::vector<Index> first_row_{0};  // [id], and how many there are; removed ones have none
};

}  // namespace tanor
