#pragma once

#include <limits>
#include <span>
#include <vector>

#include <tanor/constrainer.hpp>

namespace tanor {

/// The points of a host by numbers that never change, while the host's own may: at first they are the same. The number
/// of a point that has left is given to the next one that comes.
struct HostPoints {
  std::vector<Index> of_host;     ///< [host's number] the number here
  std::vector<Index> host_point;  ///< [number] the host's; -1: there is none
  std::vector<double> mass;       ///< [number] infinite: a support
  std::vector<double> positions;  ///< [3 number] where parts are planned
  PeriodicCell cell;              ///< of these, where there is one

  std::size_t size() const { return host_point.size(); }
  bool is_support(Index point) const { return !(mass[static_cast<std::size_t>(point)] < infinite_mass); }
  /// The numbers of all supports, in the host's order.
  std::vector<Index> list_supports() const;

  /// The host numbers its points anew: [host's number] the number of that point, -1: of one that `admit` brings. Those
  /// that are missing have left.
  void keep(std::span<const Index> numbers);
  /// After `keep`: gives numbers to the points that come, with their masses. Returns them.
  std::vector<Index> admit(std::vector<Index> numbers, std::span<const double> masses);
  /// The same points by other numbers below `count`: number i of the host becomes numbers[i]. Refuses what are none.
  HostPoints renamed(const std::vector<Index>& numbers, std::size_t count) const;

  static constexpr double infinite_mass = std::numeric_limits<double>::infinity();
};

/// to [3 numbers] := the host's points; `number` [host's number] says which is which.
void copy_points(const ConstPointArray& from, std::span<const Index> number, double* to);

}  // namespace tanor
