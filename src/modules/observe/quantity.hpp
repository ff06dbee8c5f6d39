#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/units.hpp>

#include "observe/arguments.hpp"
#include "observe/instant.hpp"

namespace tanor::detail {

/// A quantity of things of a system, such as the tension of the rods of a group: [members x parts] numbers.
struct Quantity {
  Dimension dimension = Dimension::None;
  Needs needs{};
  std::function<void(const ObservedInstant& at, double* values)> evaluate{};
  std::vector<std::string> parts{};  ///< names of the parts of a member, "x", "y", "z"; none for a number
  std::size_t num_members = 1;
  std::function<std::string(std::size_t)> name_member = [](std::size_t) { return std::string(); };
  /// Returns the constraint, support or force of a member; nothing if it is none of these.
  std::function<std::optional<Thing>(std::size_t)> thing = [](std::size_t) { return std::nullopt; };
  bool is_sum = false;                ///< members are added up where nothing else is said
  std::vector<std::size_t> absent{};  ///< members that were taken out, which have no numbers

  std::size_t num_parts() const { return std::max<std::size_t>(1, parts.size()); }
  /// Returns true if all members were taken out.
  bool is_gone() const { return absent.size() == num_members; }
};

/// Returns the quantity of one number, find(instant).
template <class Find>
Quantity one_number(Dimension dimension, Needs needs, Find find) {
  return {dimension, needs, [find](const ObservedInstant& at, double* values) { values[0] = find(at); }};
}

/// One row of the table of quantities.
struct QuantityKind {
  std::string_view name;
  std::string_view arguments;  ///< as in "rods" or "thing, axis, about"
  std::string_view what;       ///< description in one line
  Quantity (*make)(const Things& things, const Arguments& arguments);
};

/// Return true for what pulls along a line: rods and pulleys; springs and bonds.
bool has_tension(const Constraint& group);
bool has_tension(const Force& force);

Quantity make_temperature(const Things& things, const Arguments& arguments);
Quantity make_pressure(const Things& things, const Arguments& arguments);
Quantity make_virial(const Things& things, const Arguments& arguments);

/// All quantities of this version.
std::span<const QuantityKind> quantity_kinds();

}  // namespace tanor::detail
