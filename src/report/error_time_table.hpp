#pragma once

#include <filesystem>
#include <string>

#include "report/error_time.hpp"
#include "report/json_text.hpp"

namespace tanor::report {

/// The table as text, for a screen.
std::string format_error_time(const ErrorTimeTable& table);

/// The same as JSON, with the names of the columns of `error_time.csv`.
Json describe_error_time(const ErrorTimeTable& table);

/// Rows of `directory/error_time.csv` for the page of a run: method, wall_s, error_m; none: there is no such file, or
/// none that says of which scene it is. Behind the methods of another scene stands that one's name.
Json read_error_time(const std::filesystem::path& directory, const std::string& scene_checksum);

/// `error_time.csv`, `error_time.md` (Markdown), `error_time.svg` (both axes logarithmic) and `error_time.png` in a
/// folder. Says why there is no PNG; empty: there is one.
std::string write_error_time(const std::filesystem::path& directory, const ErrorTimeTable& table);

}  // namespace tanor::report
