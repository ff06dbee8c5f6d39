#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <map>
#include <set>
#include <vector>

namespace tanor::detail {

/// Says how the rods of one island join its points. Moving points are 0 … num_points - 1. Each end at a support is a
/// place of its own, num_points and above. Rods are sorted, each from its lower end to its higher one.
struct IslandTopology {
  int num_points = 0, num_supports = 0;
  std::vector<std::array<int, 2>> rods;

  auto operator<=>(const IslandTopology&) const = default;
};

/// The elimination of S = K'M^-1K of one island, written down once for all islands of its topology: S = L D L' in an
/// order of little fill. The numbers of a column stand together, the diagonal first. Among rows of equal degree, the
/// one that waits for the fewest others goes first, so that a path is eliminated from both ends at once.
class IslandSchedule {
 public:
  explicit IslandSchedule(const IslandTopology& given);

  /// A product of two rods that share a moving point of mass m: S += sign/m u_a.u_b.
  struct Product {
    int slot, a, b, point;
    double sign;
  };
  struct Column {
    int row;         ///< the rod that is eliminated
    int first, end;  ///< its slots; the first one is the diagonal
    int targets;     ///< place in `targets` of its first pair
  };

  IslandTopology topology;
  std::vector<Product> products;  ///< off the diagonal, by slot
  std::vector<Column> columns;    ///< in the order of elimination
  std::vector<int> slot_row;      ///< [slot] the rod of the entry
  std::vector<int> targets;       ///< slot of the product of entries e >= f of a column: for each f, for each e
  int num_slots = 0;
  std::size_t num_fill_slots = 0;  ///< slots without a product

  /// Returns the number of multiplications of one factorization and solve.
  double flops() const { return 2.0 * static_cast<double>(targets.size()) + 4.0 * num_slots; }

 private:
  using Slots = std::map<std::array<int, 2>, int>;  // the key is two rows, in either order
  Slots eliminate(std::vector<std::set<int>> neighbours);
};

}  // namespace tanor::detail
