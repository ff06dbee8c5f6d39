#pragma once

#include <filesystem>
#include <string>

#include "report/error_time.hpp"
#include "report/json_text.hpp"

namespace tanor::report {

/// Returns the table as text for a terminal.
std::string format_error_time(const ErrorTimeTable& table);

/// Returns the same as JSON, with the column names of `error_time.csv`.
Json describe_error_time(const ErrorTimeTable& table);

/// Returns the rows of `directory/error_time.csv` for the page of a run: method, wall_s, error_m. Returns none if there
/// is no such file, or none that tells its scene. Methods of another scene are followed by the name of that scene.
Json read_error_time(const std::filesystem::path& directory, const std::string& scene_checksum);

/// Writes `error_time.csv`, `error_time.md` (Markdown), `error_time.svg` (both axes logarithmic) and `error_time.png`
/// into a folder. Returns why there is no PNG, or an empty text if there is one.
std::string write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table);

}  // namespace tanor::report
