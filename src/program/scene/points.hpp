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

/// Reads "generate": points made by rule and the rods between them, named `rods`.
///
/// Keys of all kinds: `spacing` (length of each rod, 0.1), `mass` (of each point, 0.1), `seed` (1). The same seed gives
/// the same points on every machine, up to the last bits that contracted multiply-adds may change.
///
/// - `chain`: `count` rods (10) from the origin along `direction` ([1, 0, 0]);
///   with `anchored` (false) the first point is a fixed support.
/// - `ring`: a regular polygon of `count` rods (10; at least 3) around the origin in the xy plane.
/// - `net`: `columns` x `rows` points (10 x 10) in the xy plane, x running first; rods along x and y.
/// - `lattice`: `size` [a, b, c] points ([4, 4, 4]), x running first, then y; rods along x, y and z.
/// - `tree`: `count` rods (10); each new point hangs on an earlier one, drawn uniformly, in a random direction.
/// - `clusters`: `clusters` (10) separate random walks of `count` rods (10), begun on a cubic grid.
/// - `melt`: `chains` (10) random walks of `count` rods (10) in a cube with 0.85 points per spacing^3,
///   turned back at its faces; velocities of the canonical ensemble with kT = `temperature` (1) that keep
///   the lengths of the rods. With `bonds` "energies" (rods) no rods but a bead-spring model: forces `bonds`,
///   `bendings` and `beads` with `epsilon` (1) and the stiffness `bending` (1.5), on a lattice at the start.
PointSet read_generate(const Cursor& generate, const Context& context);

/// Reads "import": {"file", "format", "bonds", "types", "angles", "mass"}. Returns points, rods (named `rods`) and
/// rigid angles (named `angles`) of another program's file.
PointSet read_import(const Cursor& import, const Context& context);

}  // namespace tanor::scene
