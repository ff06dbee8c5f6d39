#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tanor/motion.hpp>

#include "report/json_text.hpp"
#include "scene/reference_state.hpp"
#include "scene/scene.hpp"

namespace tanor::report {

/// One run of a method: what it cost and how far it ended from the reference.
struct ErrorTimeRow {
  Method method;
  double step = 0.0;       ///< s; 0 for adaptive methods
  double tolerance = 0.0;  ///< rtol; 0 for fixed steps
  std::size_t steps = 0, factorizations = 0;
  double wall_s = 0.0;  ///< of the steps alone, without set-up; for short runs the median of three
  double error = 0.0;   ///< largest distance of a point from the reference at t_end, m; NaN if it was not reached
  double reference_error = 0.0;  ///< error of the reference itself, m: the uncertainty of `error`
  double order = 0.0;      ///< log2 of the error ratio to the row before (fixed steps are halved); 0 in the first row
  double violation = 0.0;  ///< largest of the run, relative
  double energy_drift = 0.0;
  std::string trouble;  ///< why t_end was not reached; empty if it was
};

/// Error against run time of a scene.
struct ErrorTimeTable {
  std::string scene, source;
  double t_end = 0.0;
  int threads = 1;
  struct Reference {
    Method method;
    std::string setting;            ///< "taylor with rtol 1e-13", "chain10.txt"
    std::optional<double> error{};  ///< distance from its own run with 100 times the tolerance, m; none for a file
  };
  std::vector<Reference> references;  ///< one for each method of the rows
  std::vector<ErrorTimeRow> rows;
  std::vector<std::string> left_out;  ///< "taylor: <force> has no series": methods that the scene refuses, and why
  Outcome outcome;                    ///< why no reference was found for a method; its rows and later ones are missing
  std::string scene_checksum = {};    ///< as `make_scene_checksum` makes it
  Units units{};
};

/// Callbacks for the caller who waits for a table. `say` receives a line after each run. `goes_on` is called after each
/// step; if it returns false, the table ends with the rows that are there.
struct Watcher {
  std::function<void(const std::string&)> say;
  std::function<bool()> goes_on;
};

/// Runs each method with four step sizes (halved) or tolerances (divided by 100), and compares the results with the
/// given file. Without a file the reference is a finer run of *another* method: dop853 for taylor, taylor for all
/// others. If taylor refuses the scene, dop853 takes its place, and dopri5 for dop853. A reference is refined until its
/// own error is a tenth of the smallest error that it finds, or until rounding dominates. Throws InputError if the
/// scene refuses all methods.
ErrorTimeTable measure_error_time(const scene::Scene& scene, std::span<const Method> methods,
                                  const scene::ReferenceState* given, const Watcher& watcher);

/// Returns "rtol 1e-05" or "step 0.005".
std::string describe_setting(const ErrorTimeRow& row);

/// Returns the table as text for a terminal.
std::string format_error_time(const ErrorTimeTable& table);

/// Returns the same as JSON, with the column names of `error_time.csv`.
Json describe_error_time(const ErrorTimeTable& table);

/// Returns the rows of `directory/error_time.csv` for the page of a run: method, wall_s, error. Returns none if there
/// is no such file, or none that tells its scene. Methods of another scene are followed by the name of that scene.
Json read_error_time(const std::filesystem::path& directory, const std::string& scene_checksum);

/// Writes `error_time.csv`, `error_time.md` (Markdown), `error_time.svg` (both axes logarithmic) and `error_time.png`
/// into a folder. Returns why there is no PNG, or an empty text if there is one.
std::string write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table);

}  // namespace tanor::report
