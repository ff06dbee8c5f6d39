#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::report {

/// The part of a system that a trajectory shows: some points, and the rods between them.
struct ShownParts {
  std::size_t num_points = 0;                     ///< shown ones, m
  std::vector<Index> points;                      ///< m, of the system, in the order of the files
  std::vector<bool> is_support;                   ///< m
  std::vector<std::array<std::int32_t, 2>> rods;  ///< both ends, as positions in `points`, behind them in `images`
  std::vector<std::size_t> rod_rows;              ///< row of each rod among the multipliers
  std::vector<std::int32_t> loose_points;         ///< positions in `points` that no shown rod touches

  /// The end r_j + offset of a rod across the edge of a periodic sample. The rod is drawn beside its point i, not
  /// across the sample.
  struct Image {
    std::int32_t point;  ///< position of j in `points`
    Vector3 offset;      ///< m
  };
  std::vector<Image> images;
};

/// Chooses what is shown. `chosen` names the points in their order; empty: all points.
ShownParts choose_parts(const System& system, std::span<const Index> chosen);

/// Copies the rows of the shown points. `all` has 3n numbers; the result has 3m and reuses `rows`.
void gather_points(const ShownParts& shown, std::span<const double> all, std::vector<double>* rows);

/// Tensions of the shown rods, N: -lambda. `multipliers` of all constraints (d); a rod that they do not reach has NaN.
std::vector<double> find_tensions(const ShownParts& shown, std::span<const double> multipliers);

/// The rows of the images among those of the shown points (3m).
std::vector<double> gather_images(const ShownParts& shown, std::span<const double> rows);
/// The same for positions: the images are shifted.
std::vector<double> gather_shifted_images(const ShownParts& shown, std::span<const double> positions);

/// m/s^2; 0 where the system has none.
Vector3 find_gravity(const System& system);

}  // namespace tanor::report
