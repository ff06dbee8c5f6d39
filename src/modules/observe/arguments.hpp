#pragma once

#include <cstddef>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <tanor/system.hpp>

#include "base/vec3.hpp"
#include "system/formula.hpp"

namespace tanor::detail {

/// One argument of a quantity, and where it stands in the text.
struct Argument {
  std::string text;  ///< without its quotes
  std::size_t place = 0;
  bool is_name = false;  ///< it stood in quotes, and is no number, list or word

  [[noreturn]] void fail(const std::string& problem) const { throw TextFault{place, problem}; }
};

/// The arguments of a quantity.
struct Arguments {
  std::string_view quantity;
  std::size_t place = 0;  ///< of the quantity in the text
  std::vector<Argument> list;

  /// Throws TextFault unless there are so many.
  void require(std::size_t least, std::size_t most, std::string_view wanted) const;
  std::size_t size() const { return list.size(); }
  const Argument& operator[](std::size_t i) const { return list[i]; }
};

/// Follows quotes through a text. Only the beginning of an argument opens them, so that Bob's needs none; inside, two
/// stand for one.
class Quotes {
 public:
  /// Returns true if the next character is one of the quotes or between them.
  bool hold(char c) {
    const bool was_open = is_open_;
    if (c == '\'') is_open_ = !is_open_ && (before_ == '(' || before_ == ',' || before_ == '\'');
    if (was_open && !is_open_) return before_ = '\'', true;
    if (c != ' ' && c != '\t' && c != '\n' && c != '\r') before_ = c == '\'' ? 'x' : c;
    return is_open_;
  }

 private:
  char before_ = '\0';  ///< the last character that is no blank; a quote if it closed
  bool is_open_ = false;
};

/// Reads "(a, [1, 2], 'b')" at a place of the text, which moves behind it.
Arguments read_arguments(std::string_view text, std::string_view quantity, std::size_t begin, std::size_t* place);

/// Returns a name as an argument has it, in quotes where it would be read otherwise without.
std::string quoted_name(const std::string& name);

/// A group of constraints, an entry of supports, or a force; or one member of it.
struct Thing {
  enum class List { Constraints, Supports, Forces } list;
  std::size_t index = 0;
  std::optional<std::size_t> member{};

  friend bool operator==(const Thing&, const Thing&) = default;
};

/// Returns the place of a thing in its system, "constraints/2" or, of a member, "supports/0/1".
std::string place_in_system(const Thing& thing);

/// The names in the system of a host, which edits have changed, and whose forces are sums on points.
struct HostNames {
  struct Group {
    std::size_t size = 0;             ///< number of members that were added
    std::vector<std::size_t> left{};  ///< [member] its number among these, ascending; empty if all are left
  };
  std::vector<Group> groups;         ///< of constraints
  std::vector<std::string> removed;  ///< groups without a member left
};

/// Finds by their names what a system has. Names are those of entries of lists (`constraint_name`, …), with "[3]"
/// behind them for a member. In quotes they may hold anything.
class Things {
 public:
  /// `absent` are members that were taken out of the system. `host` is given if it is that of a host. All must outlive
  /// this.
  explicit Things(const System& system, std::span<const Thing> absent = {}, const HostNames* host = nullptr)
      : system_(system), absent_(absent), host_(host) {}

  const System& system() const { return system_; }

  /// Returns what has a name in some of the lists.
  std::vector<Thing> find_all(const std::string& name, std::initializer_list<Thing::List> lists) const;
  /// Finds a thing in some of the lists. Throws TextFault that names similar ones.
  Thing find(const Argument& argument, std::initializer_list<Thing::List> lists) const;
  /// Reads points: a number, a list [0, 4, 7], the name of an entry of supports, or all.
  std::vector<Index> points(const Argument& argument) const;
  Index point(const Argument& argument) const;
  /// Reads x, y, z or [a, b, c], which is not zero; returns it with length 1.
  Vec3 axis(const Argument& argument) const;
  /// Reads [a, b, c].
  std::optional<Vec3> vector(const Argument& argument) const;

  std::string name(const Thing& thing) const;
  /// Returns the name of a point: of its entry of supports, or "point 7".
  std::string name_point(Index point) const;
  std::size_t num_members(const Thing& thing) const;
  /// Returns the first equation of a group of constraints.
  std::size_t first_row(std::size_t group) const { return names().first_rows[group]; }
  /// Returns true if a member was taken out, by itself or with its entry, or all members of an entry.
  bool is_absent(const Thing& thing) const;
  /// Returns which members of a thing were taken out, [member]; empty if none of the system was.
  std::vector<bool> find_absent(const Thing& of) const;
  /// Returns the system as it acts after what was taken out, without friction and coordinates.
  System what_is_left() const;
  /// Returns the numbers that the members of a thing have in names; empty if these are 0, 1, 2, …
  std::span<const std::size_t> numbers(const Thing& thing) const;
  /// Throws TextFault if the quantity needs to know each force, and a host gives their sums.
  void require_forces(const Arguments& arguments) const;

 private:
  std::size_t place_of(std::size_t number, const Thing& thing, const Argument& argument) const;
  std::string list_name(Thing::List list, std::size_t index) const;
  std::size_t list_size(Thing::List list) const;

  /// Holds what the system has by names and by points. Copies of Things share it.
  struct Names {
    std::unordered_map<std::string, std::vector<Thing>> things;
    std::unordered_map<Index, Thing> supports;  // members
    std::vector<std::size_t> first_rows;        // [group] of constraints
  };
  const Names& names() const;

  const System& system_;
  std::span<const Thing> absent_;
  const HostNames* host_;
  mutable std::shared_ptr<const Names> names_{};  // null until something is looked up
};

}  // namespace tanor::detail
