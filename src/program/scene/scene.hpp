#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <tanor/equilibrium.hpp>
#include <tanor/modes.hpp>
#include <tanor/motion.hpp>

#include "scene/overrides.hpp"
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
  std::vector<std::filesystem::path> files;  ///< all files that were read: the scene file, then those it names
  std::string name;
  std::string source;  ///< origin of the points: "inline", "generate: chain", "import: data.chain (lammps-data)"
  std::vector<std::string> left_out;  ///< what acts in an imported file but not here, a sentence each
  System system;
  std::vector<Observable> observables;
  std::vector<Event> events;
  MotionOptions motion;
  double t_start = 0.0;                                     ///< s
  double t_end = std::numeric_limits<double>::quiet_NaN();  ///< s, after t_start; NaN: not given
  double output_every = 0.0;                                ///< s; 0: start and end only
  std::vector<Index> output_points;                         ///< empty: all
  TrajectoryFormats trajectory;
  SolverOptions solver;
  CertificatePolicy certificate;
  EquilibriumOptions equilibrium;           ///< without those of `solver`
  ModesOptions modes;                       ///< without those of `solver`
  std::vector<std::string> buckling_loads;  ///< names of forces; empty if no load factor is requested
  std::vector<std::string> old_names;       ///< old names in use: "/solver/way: its name is linear_solver"

  bool has_end() const { return !std::isnan(t_end); }
};

/// Returns all options of an equilibrium, including those of "solver".
EquilibriumOptions equilibrium_options(const Scene& scene);

/// Return the options for modes and buckling about an equilibrium of the scene.
ModesOptions modes_options(const Scene& scene);
BucklingOptions buckling_options(const Scene& scene);

/// Reads and validates a scene file, in which values of the command line replace its own. Throws InputError with
/// `where()` = "<file>: <JSON pointer>" (line and column if the text is not JSON), or the option that is wrong.
Scene load_scene(const std::filesystem::path& file, const Overrides& overrides = {});

/// Loads a scene that is to move, whose end must be known.
Scene load_moving_scene(const std::filesystem::path& file, const Overrides& overrides);

/// Loads a scene from text; relative paths inside are relative to `file`.
Scene parse_scene(const std::string& text, const std::filesystem::path& file, const Overrides& overrides = {});

/// Adds the events of a scene. Throws InputError with their places, /events/0.
void add_events(const Scene& scene, Simulation* simulation);

}  // namespace tanor::scene
