#pragma once

#include <optional>
#include <string>
#include <vector>

#include <tanor/system.hpp>

#include "scene/context.hpp"

namespace tanor::scene {

/// The points of a scene wherever they come from, with the supports and rods that come along.
struct PointSet {
  std::string source;              ///< "inline", "generate: chain", "import: data.chain (lammps-data)"
  std::vector<double> positions;   ///< 3n, m
  std::vector<double> velocities;  ///< 3n, m/s; empty: at rest
  std::vector<double> masses;      ///< n, kg
  std::vector<Support> supports;
  std::vector<Constraint> constraints;
  std::vector<Force> forces{};
  std::optional<Cell> cell;             ///< periodic box of an imported file
  std::vector<std::string> left_out{};  ///< what acts in an imported file and not here, a sentence each

  Index add_point(const Vector3& position) {
    positions.insert(positions.end(), position.begin(), position.end());
    return static_cast<Index>(positions.size() / 3 - 1);
  }
};

/// The key that is there of "points", "generate", "import".
Cursor find_point_source(const Cursor& root);

/// Reads it, whichever it is.
PointSet read_point_source(const Cursor& root, const Context& context);

/// "points": {"positions", "velocities", "masses"}, inline or from files.
PointSet read_points(const Cursor& points, const Context& context);

}  // namespace tanor::scene
