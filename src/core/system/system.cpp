#include <tanor/system.hpp>

#include <algorithm>

#include "base/text.hpp"
#include "system/contacts.hpp"
#include "system/members.hpp"

namespace tanor {
using namespace detail;

namespace {

template <class Entry>
std::string_view kind_of(const Entry& entry) {
  return std::visit([]<class Group>(const Group&) { return KindOf<Group>::name; }, entry);
}

/// Returns the entry's own name, or `<kind><index>`.
template <class Entry>
std::string name_of(const Entry& entry, std::size_t index) {
  const std::string& own = std::visit([](const auto& group) -> const std::string& { return group.name; }, entry);
  return own.empty() ? std::string(kind_of(entry)) + text(index) : own;
}

}  // namespace

std::size_t num_equations(const System& system) {
  std::size_t num_rows = 0;
  for (const Constraint& constraint : system.constraints) {
    const auto [members, rows_per_member] = shape_of(constraint);
    num_rows += members * rows_per_member;
  }
  return num_rows;
}

std::size_t num_contacts(const System& system, std::size_t friction) {
  const std::vector<Contact> contacts = list_contacts(system);
  return static_cast<std::size_t>(std::ranges::count(contacts, static_cast<Index>(friction), &Contact::friction));
}

std::string equation_name(const System& system, std::size_t row) {
  std::size_t first_row = 0;
  for (std::size_t group = 0; group < system.constraints.size(); ++group) {
    const auto [members, rows_per_member] = shape_of(system.constraints[group]);
    if (row < first_row + members * rows_per_member) {
      const std::size_t member = (row - first_row) / rows_per_member, part = (row - first_row) % rows_per_member;
      const std::string name = constraint_name(system, group) + "[" + text(member) + "]";
      return rows_per_member == 1 ? name : name + "." + text(part);
    }
    first_row += members * rows_per_member;
  }
  throw InputError("", "row " + text(row) + " is out of range: the system has " + text_of_count(first_row, "equation"));
}

std::string constraint_name(const System& system, std::size_t group) {
  return name_of(system.constraints.at(group), group);
}

std::string force_name(const System& system, std::size_t index) {
  return name_of(system.forces.at(index), index);
}

std::string friction_name(const System& system, std::size_t index) {
  return name_of(system.friction.at(index), index);
}

std::string coordinates_name(const System& system, std::size_t index) {
  return name_of(system.coordinates.at(index), index);
}

std::string_view kind_name(const Friction& friction) {
  return kind_of(friction);
}
std::string_view kind_name(const Coordinates& coordinates) {
  return kind_of(coordinates);
}

std::string_view kind_name(const Constraint& constraint) {
  return kind_of(constraint);
}

std::string_view kind_name(const Force& force) {
  return kind_of(force);
}

}  // namespace tanor
