#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <tanor/inverse_dynamics.hpp>

#include "base/text.hpp"
#include "cli/command_line.hpp"
#include "cli/messages.hpp"
#include "cli/output_folder.hpp"
#include "report/motion_forces.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"
#include "scene/number_table.hpp"
#include "scene/scene.hpp"

namespace tanor::cli {
using namespace detail;
using report::with_unit;

namespace fs = std::filesystem;

namespace {

/// Largest violation of the constraints by positions that count as a motion of the scene. Only the samples decide:
/// velocities and accelerations are those of the spline between them, and their violations tell how well the motion is
/// sampled.
constexpr double allowed_violation = 1e-6;
/// Fraction of the largest acceleration. If the spline's accelerations break the constraints by more, forces do not
/// have four correct digits.
constexpr double poor_acceleration = 1e-4;
/// Fewest samples for a spline of degree 5; fewer samples get a polynomial.
constexpr std::size_t fewest_samples = 6;

/// A motion from its file: r(t), or q(t) if the scene has coordinates.
struct GivenMotion {
  MotionTable table;
  bool by_coordinates;
};

GivenMotion read_motion(const fs::path& file, std::size_t num_points, std::size_t num_coordinates) {
  const scene::NumberTable rows = scene::read_number_table(file);
  const std::size_t by_points = 1 + 3 * num_points, by_coordinates = 1 + num_coordinates;
  const bool takes_coordinates = num_coordinates > 0 && by_coordinates != by_points;
  if (rows.columns != by_points && !(takes_coordinates && rows.columns == by_coordinates)) {
    std::string wanted = fmt::format("{} (t, then x, y, z of {} points)", by_points, num_points);
    if (takes_coordinates) wanted += fmt::format(" or {} (t, then {} coordinates)", by_coordinates, num_coordinates);
    throw InputError(file.string(), fmt::format("found {} columns, wanted {}", rows.columns, wanted));
  }
  std::vector<double> times, values;
  for (std::size_t k = 0; k < rows.rows; ++k) {
    times.push_back(rows(k, 0));
    for (std::size_t j = 1; j < rows.columns; ++j) values.push_back(rows(k, j));
  }
  return {naming_file(file, [&] { return MotionTable(std::move(times), std::move(values), rows.columns - 1); }),
          rows.columns != by_points};
}

/// Returns the largest of w, eta/m and u/m over the points that move.
double measure_acceleration(const System& system, const MotionState& state, const MotionForces& forces) {
  std::vector<char> moves(system.num_points(), 1);
  for (const Support& support : system.supports) {
    for (const Index i : support.points) moves[static_cast<std::size_t>(i)] = 0;
  }
  double largest = 0.0;
  for (std::size_t c = 0; c < state.acceleration.size(); ++c) {
    if (moves[c / 3] == 0) continue;
    largest = std::max(largest, std::abs(state.acceleration[c]));
    if (!forces.outcome.ok()) continue;
    largest = std::max(largest, std::abs(forces.reactions[c]) / system.masses[c / 3]);
    largest = std::max(largest, std::abs(forces.control_forces[c]) / system.masses[c / 3]);
  }
  return largest;
}

report::ForcesOfMotion find_forces(const GivenMotion& motion, InverseDynamics* problem) {
  report::ForcesOfMotion result;
  result.num_points = problem->system().num_points();
  result.num_equations = problem->num_equations();
  result.by_coordinates = motion.by_coordinates;
  for (const double t : motion.table.times()) {
    MotionState state = motion.table.at(t);
    if (motion.by_coordinates) state = problem->place(t, state);
    result.times.push_back(t);
    result.samples.push_back(problem->evaluate(t, state));
    result.acceleration_scale =
        std::max(result.acceleration_scale, measure_acceleration(problem->system(), state, result.samples.back()));
  }
  return result;
}

/// Returns why the accelerations, and with them all forces, are poorly known; empty if they are not.
std::string find_accuracy_warning(const report::ForcesOfMotion& forces, const Units& units) {
  std::string warning;
  const std::size_t count = forces.times.size();
  if (count < fewest_samples) {
    warning = fmt::format(
        "the motion has {} samples, {} are the fewest for a spline of degree 5: its accelerations are those of a "
        "polynomial of degree {}",
        count, fewest_samples, count - 1);
  }
  const std::size_t worst = forces.find_worst([](const MotionForces& sample) { return sample.acceleration.largest; });
  const Violation& violation = forces.samples[worst].acceleration;
  if (violation.largest > poor_acceleration * forces.acceleration_scale) {
    const auto acceleration = [&](double size) {
      return with_unit(fmt::format("{:.3g}", size), units.letters(Dimension::Acceleration));
    };
    warning += fmt::format(
        "{}the accelerations of the spline break the constraints by {} ({} at t = {}), the largest "
        "acceleration is {}: forces are no better; finer samples are needed",
        warning.empty() ? "" : "; ", acceleration(violation.largest), violation.where,
        with_unit(detail::text(forces.times[worst]), units.time), acceleration(forces.acceleration_scale));
  }
  return warning;
}

/// Returns why the answer is incomplete or no motion of this scene; empty if neither holds.
std::string find_trouble(const report::ForcesOfMotion& forces, std::size_t worst, const Units& units) {
  for (const MotionForces& sample : forces.samples) {
    if (!sample.outcome.ok()) return sample.outcome.what;
  }
  const Violation& violation = forces.samples[worst].position;
  if (violation.largest <= allowed_violation) return {};
  return fmt::format(
      "the motion breaks the constraints: worst by {} of its length, {} at t = {}; at most {} counts "
      "as rounding",
      report::in_words(violation.largest, "{:.3g}"), violation.where,
      with_unit(detail::text(forces.times[worst]), units.time), allowed_violation);
}

}  // namespace

ExitCode execute_forces(const Options& options) {
  scene::Scene scene = prepare(scene::load_scene(options.scene));
  const OutputFolder folder(choose_folder(options.out, scene.file), "forces");
  const fs::path& directory = folder.path();
  InverseDynamics problem =
      naming_file(options.scene, [&] { return InverseDynamics(std::move(scene.system), scene.solver); });
  const GivenMotion motion = read_motion(options.motion, problem.system().num_points(), problem.num_coordinates());
  report::ForcesOfMotion forces = naming_file(options.scene, [&] { return find_forces(motion, &problem); });
  forces.scene = scene.name;
  forces.motion = options.motion.string();
  forces.units = problem.system().units;
  forces.groups = report::list_groups(problem.system());
  report::write_forces(directory, forces);

  const Units& units = problem.system().units;
  const auto violation = [](const MotionForces& sample) { return sample.position.largest; };
  const auto control = [](const MotionForces& sample) { return sample.largest_control; };
  const std::size_t worst = forces.find_worst(violation), largest = forces.find_worst(control);
  const MotionForces& controlled = forces.samples[largest];
  const Violation& violated = forces.samples[worst].position;
  const std::string where =
      violated.where.empty()
          ? ""
          : fmt::format(" ({}, t = {})", violated.where, with_unit(detail::text(forces.times[worst]), units.time));
  if (options.json) {
    print_json_file(directory / report::forces_name);
  } else {
    fmt::print("largest control force {} (point {}, t = {}); largest violation {}{}; results in {}\n",
               with_unit(report::in_words(controlled.largest_control, "{:.3g}"), units.force),
               controlled.controlled_point, with_unit(detail::text(forces.times[largest]), units.time),
               report::in_words(violated.largest, "{:.3g}"), where, typed(directory));
  }
  if (const std::string warning = find_accuracy_warning(forces, units); !warning.empty())
    print_message(options.scene.string() + ": warning: " + warning, Tone::Warning);
  const std::string trouble = find_trouble(forces, worst, units);
  if (trouble.empty()) return ExitCode::Done;
  return tell(options.scene, trouble);
}

}  // namespace tanor::cli
