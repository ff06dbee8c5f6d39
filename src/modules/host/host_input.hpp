#pragma once

#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/constrainer.hpp>

#include "base/check_size.hpp"
#include "base/text.hpp"
#include "host/host_parts.hpp"

/// \file Checks of what a host hands over. Errors are thrown as InputError.
namespace tanor::detail {

/// Makes the points of a host, with the host's own numbers.
HostPoints make_points(std::span<const double> masses, const ConstPointArray& at);

/// Makes a system of the constraints on the points as the host numbers them, for checks and for messages.
System make_system(const HostPoints& points, std::vector<Constraint> constraints);

/// The way of a host that has constraints to one side.
inline constexpr const char* one_sided_host = "a Constrainer holds both, a Simulation finds where gaps close";
inline constexpr const char* unbreakable_host = "the members of a Constrainer go where its host removes them";

/// Throws if the group, on points with the host's numbers, cannot be added.
void check_group(const HostParts& parts, const Constraint& group, std::size_t num_images);

/// Adds the group, on points with the host's numbers, to the parts. "initial" becomes the values at the present
/// positions, and `images` [row] become those of each member. Returns the id of the first member.
ConstraintId add_group(Constraint group, std::vector<std::array<int, 3>> images, HostParts* parts);

/// Throws unless a point may have this mass instead of `before`. An infinite mass makes a support.
void check_mass(double mass, std::optional<double> before, std::size_t point);

/// Returns the numbers of the points from[i], -1 for a new one. Throws if they are wrong, see Constrainer::renumber.
std::vector<Index> check_numbers(const HostParts& parts, std::span<const std::int64_t> from,
                                 std::span<const double> masses);

template <class Number>
void check_array(const BasicPointArray<Number>& array, std::size_t num_points, std::size_t width, const char* name) {
  if (array && array.index == nullptr && array.size < width * num_points)
    check_size(array.size, width * num_points, name);
}

template <class Number>
void require_array(const BasicPointArray<Number>& array, std::size_t num_points, const char* name) {
  if (!array && num_points > 0) throw InputError("", std::string(name) + " are missing");
  check_array(array, num_points, 3, name);
}

inline void check_finite(double number, const char* name) {
  if (!std::isfinite(number)) throw InputError("", std::string(name) + " = " + text(number) + " is not a number");
}

}  // namespace tanor::detail
