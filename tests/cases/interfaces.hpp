#pragma once

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>
#include <tanor/motion.hpp>

#include "folder.hpp"

/// The interfaces that give an answer are the library called from C++ and the program on a scene file.
namespace tanor::cases {

/// The result of a run at its end, with all points in the scene's order.
struct Answer {
  double t = 0.0;
  std::vector<double> positions, velocities, accelerations, multipliers, reactions, support_forces;
  double position_violation = 0.0, velocity_violation = 0.0;
  double energy = 0.0, energy_start = 0.0, work_of_supports = 0.0;
};

/// Computes the answer of a case at t_end. `scene_name` is a file of tests/cases/scenes, and `system` the same in C++.
using Interface = Answer (*)(const std::string& scene_name, const System& system, const MotionOptions& options,
                             double t_end);

inline Answer through_library(const std::string&, const System& system, const MotionOptions& options, double t_end) {
  Simulation simulation(system, options);
  if (const Outcome outcome = simulation.advance_to(t_end); !outcome.ok()) throw std::runtime_error(outcome.what);
  const auto copy = [](std::span<const double> array) { return std::vector<double>(array.begin(), array.end()); };
  const MotionReport& report = simulation.report();
  return {simulation.time(),
          copy(simulation.positions()),
          copy(simulation.velocities()),
          copy(simulation.accelerations()),
          copy(simulation.multipliers()),
          copy(simulation.reactions()),
          copy(simulation.support_forces()),
          report.violation.position,
          report.violation.velocity,
          report.energy.now,
          report.energy.start,
          report.energy.work_of_supports};
}

#ifdef TANOR_PROGRAM

inline std::string scene_file(const std::string& scene_name) {
  return TANOR_SOURCE_DIR "/tests/cases/scenes/" + scene_name + ".json";
}

inline void run_program(const std::string& arguments) {
  const int status = std::system((TANOR_PROGRAM " " + arguments).c_str());
  if (status != 0) throw std::runtime_error("tanor " + arguments + " ended with " + std::to_string(status));
}

inline nlohmann::json read_json(const std::filesystem::path& file) {
  return nlohmann::json::parse(std::ifstream(file));
}

/// Turns an array of one row a point into a flat array, point by point.
inline std::vector<double> flatten(const nlohmann::json& rows) {
  std::vector<double> result;
  for (const nlohmann::json& row : rows) {
    for (const nlohmann::json& x : row) result.push_back(x.get<double>());
  }
  return result;
}

/// Returns the options as the command line spells them.
inline std::string spell(const MotionOptions& options) {
  const auto digits = [](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.17g", x);
    return std::string(buffer);
  };
  return "--method " + std::string(name_of(options.method)) +
         (options.step > 0.0 ? " --step " + digits(options.step)
                             : " --rtol " + digits(options.rtol) + " --atol " + digits(options.atol));
}

inline Answer through_program(const std::string& scene_name, const System&, const MotionOptions& options,
                              double t_end) {
  const Folder folder;
  run_program("run " + scene_file(scene_name) + " --quiet --out " + (folder / "out").string() + " " + spell(options) +
              " --t-end " + std::to_string(t_end));
  const nlohmann::json summary = read_json(folder / "out/summary.json");
  const nlohmann::json& end = summary.at("final");
  const nlohmann::json& energy = summary.at("energy");
  return {end.at("t"),
          flatten(end.at("positions")),
          flatten(end.at("velocities")),
          flatten(end.at("accelerations")),
          end.at("multipliers"),
          flatten(end.at("reactions")),
          flatten(end.at("support_forces")),
          summary.at("violation").at("position_max"),
          summary.at("violation").at("velocity_max"),
          energy.at("end"),
          energy.at("start"),
          energy.at("work_of_supports")};
}

#endif

}  // namespace tanor::cases
