#pragma once

#include <limits>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

namespace tanor::detail {

/// The points of a host by numbers that never change, while the host's own may. At first both are the same. The number
/// of a point that has left is given to the next one that comes.
struct HostPoints {
  std::vector<Index> of_host;     ///< [host's number] the number here
  std::vector<Index> host_point;  ///< [number] the host's; -1 if there is none
  std::vector<double> mass;       ///< [number] infinite for a support
  std::vector<double> positions;  ///< [3 number] positions at which parts are planned
  PeriodicCell cell;              ///< the cell of these positions, if there is one

  std::size_t size() const { return host_point.size(); }
  bool is_support(Index point) const { return !(mass[static_cast<std::size_t>(point)] < infinite_mass); }
  /// Returns the numbers of all supports, in the host's order.
  std::vector<Index> list_supports() const;

  /// Numbers the host's points anew: `numbers` [host's number] is the number of that point, -1 for one that `admit`
  /// adds. Points that are missing have left.
  void keep(std::span<const Index> numbers);
  /// Gives numbers and masses to the new points, after `keep`. Returns the numbers of these points.
  std::vector<Index> admit(std::vector<Index> numbers, std::span<const double> masses);
  /// Returns the same points with other numbers below `count`: the host's point i has numbers[i]. Refuses numbers that
  /// are out of range or occur twice.
  HostPoints renamed(const std::vector<Index>& numbers, std::size_t count) const;

  /// Makes a system of some points, in this order, whose supports have the name "supports".
  System make_system(std::span<const Index> numbers) const;

  static constexpr double infinite_mass = std::numeric_limits<double>::infinity();
};

/// Copies the host's points to `to` [3 numbers]; `number` [host's number] is the number of each.
void copy_points(const ConstPointArray& from, std::span<const Index> number, double* to);

}  // namespace tanor::detail
