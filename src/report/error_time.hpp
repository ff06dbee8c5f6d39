#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "scene/scene.hpp"

namespace tanor::report {

/// One run of a method: what it cost and how far it ended from the reference.
struct ErrorTimeRow {
  Method method;
  double step = 0.0;       ///< s; 0 for adaptive methods
  double tolerance = 0.0;  ///< rtol; 0 for fixed steps
  std::size_t steps = 0;
  double wall_s = 0.0;       ///< of the steps alone, without set-up
  double error = 0.0;        ///< largest distance of a point from the judge at t_end, m
  double judge_error = 0.0;  ///< of the judge itself, m: what the error is uncertain by
  double order = 0.0;        ///< log2 of the error's ratio to the row before (fixed steps halved); 0: first row
  double violation = 0.0;    ///< largest of the run, relative
  double energy_drift = 0.0;
  std::string trouble;  ///< why it did not arrive; empty: it did
};

/// Error against run time of a scene.
struct ErrorTimeTable {
  std::string scene, source;
  double t_end = 0.0;
  int threads = 1;
  struct Judge {
    Method judged, method;
    std::string setting;  ///< "rtol 1e-12", "step 0.0003125"
    double error = 0.0;   ///< its distance from its own run with twice the step or 100 times the tolerance, m
  };
  std::vector<Judge> judges;  ///< one for each method of the rows
  std::vector<ErrorTimeRow> rows;
  Outcome outcome;  ///< why a judge did not arrive; the rows that it was to judge are missing
};

/// Runs each method with four step sizes (halved) or tolerances (a hundredth each) against a finer run of *another*
/// method, the judge: dop853 is judged by dopri5, all others by dop853, each with a tight tolerance. A judge is
/// refined, four times at most, until its own error is a tenth of the smallest that it finds. `say` hears a line after
/// each run.
ErrorTimeTable measure_error_time(const scene::Scene& scene, const std::vector<Method>& methods,
                                  const std::function<void(const std::string&)>& say);

/// The table as text, one screen wide.
std::string format_error_time(const ErrorTimeTable& table);

/// `error_time.csv` and `error_time.svg` (both axes logarithmic) in a folder.
void write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table);

}  // namespace tanor::report
