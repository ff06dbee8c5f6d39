#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>

#include "scene/overrides.hpp"
#include "scene/periodic_cell.hpp"
#include "scene/trajectory.hpp"

namespace tanor::scene {

/// When the certificate is computed ("certificate" of docs/scene-format.md).
struct CertificatePolicy {
  enum class When { Off, Final, Always, Every } when = When::Final;
  int every = 0;  ///< steps, for Every
};

/// A scene file, read and checked: everything that a sub-command needs.
struct Scene {
  std::filesystem::path file;
  std::vector<std::filesystem::path> files;  ///< all that were read: the scene file, then those it names
  std::string name;
  std::string source;  ///< where the points come from: "inline", "generate: chain", "import: data.chain (lammps-data)"
  std::vector<std::string> left_out;  ///< what acts in an imported file and not here, a sentence each
  System system;
  MotionOptions motion;
  double t_start = 0.0;              ///< s
  double t_end = 0.0;                ///< s; 0: not given
  double output_every = 0.0;         ///< s; 0: start and end only
  std::vector<Index> output_points;  ///< empty: all
  TrajectoryFormats trajectory;
  std::optional<Cell> cell;  ///< periodic box: of the imported file, else of the first pair forces that have one
  SolverOptions solver;
  CertificatePolicy certificate;
  EquilibriumOptions equilibrium;           ///< without those of `solver`
  ModesOptions modes;                       ///< without those of `solver`
  std::vector<std::string> buckling_loads;  ///< names of forces; empty: no load factor is asked for
  std::vector<std::string> old_names;       ///< that it uses: "/solver/way: its name is linear_solver"
};

/// Reads and validates a scene file, with the command line's values over its own. Throws InputError with `where()` =
/// "<file>: <JSON pointer>" (line and column where the text is no JSON), or the option that is wrong.
Scene load_scene(const std::filesystem::path& file, const Overrides& overrides = {});

/// The same for a scene that is to move: its end must be known.
Scene load_moving_scene(const std::filesystem::path& file, const Overrides& overrides);

/// The same as load_scene from text; relative paths inside are relative to `file`.
Scene parse_scene(const std::string& text, const std::filesystem::path& file, const Overrides& overrides = {});

}  // namespace tanor::scene
