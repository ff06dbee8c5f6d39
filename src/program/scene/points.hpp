#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// The points of a scene, whatever their source, with the supports and rods that come with them.
struct PointSet {
  std::string source;              ///< "inline", "generate: chain", "import: data.chain (lammps-data)"
  std::vector<double> positions;   ///< 3n, m
  std::vector<double> velocities;  ///< 3n, m/s; empty: at rest
  std::vector<double> masses;      ///< n, kg
  std::vector<Support> supports;
  std::vector<Constraint> constraints;
  std::vector<Force> forces{};
  std::optional<Cell> cell;             ///< periodic box of an imported file
  Units units{};                        ///< of an imported file
  std::vector<std::string> left_out{};  ///< what acts in an imported file but not here, a sentence each

  Index add_point(const Vector3& position) {
    positions.insert(positions.end(), position.begin(), position.end());
    return static_cast<Index>(positions.size() / 3 - 1);
  }
};

/// Returns the one of the keys "points", "generate", "import" that is present.
Cursor find_point_source(const Cursor& root);

/// Reads the points from any of these sources.
PointSet read_point_source(const Cursor& root, const Context& context);

/// Reads "points": {"positions", "velocities", "masses"}, inline or from files.
PointSet read_points(const Cursor& points, const Context& context);

}  // namespace tanor::scene
