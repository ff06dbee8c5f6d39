#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include <tanor/system.hpp>

#include "base/checksum.hpp"
#include "system/members.hpp"

namespace tanor::detail {

/// Returns a number that tells a System from others by its points, masses, members of constraints and kinds of all
/// entries. (What functions compute cannot be compared.)
inline std::uint64_t fingerprint_of(const System& system) {
  Checksum sum;
  const auto add = [&](std::size_t number) { sum.add(std::span<const std::size_t>(&number, 1)); };
  const auto add_entries = [&](const auto& entries) {
    add(entries.size());
    for (const auto& entry : entries) add(entry.index());
  };
  add(system.num_points());
  sum.add(std::span<const double>(system.masses));
  sum.add(std::span<const double>(system.positions));
  for (const Support& support : system.supports) {
    add(support.points.size());
    sum.add(std::span<const Index>(support.points));
  }
  add_entries(system.constraints);
  for_each_member(system, [&](std::span<const Index> points, int) {
    add(points.size());
    sum.add(points);
  });
  add_entries(system.forces);
  add_entries(system.friction);
  add_entries(system.coordinates);
  return sum.value();
}

}  // namespace tanor::detail
