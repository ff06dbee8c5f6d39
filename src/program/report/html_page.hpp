#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tanor/modes.hpp>

#include "report/recording.hpp"
#include "report/summary.hpp"

namespace tanor::report {

/// Returns the page without a run, as src/program/report/page makes it, or an empty text if the program was built
/// without node.
std::string_view html_page_template();
inline bool has_html_page() {
  return !html_page_template().empty();
}

inline constexpr const char* html_page_name = "report.html";
/// Stands in the page before the two ends of its colours of tensions, "[-3.1, 3.1]".
inline constexpr std::string_view html_colours_key = R"("colours":{"tensions":)";

/// Writes the self-contained page `directory/report.html`: the facts of a run, its motion and its histories. A table
/// `error_time.csv` in the folder is shown too.
void write_html_page(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation,
                     const Recording& recording);
/// Writes the page of a run that goes on. It requests nothing from the simulation that is not known yet.
void write_running_page(const std::filesystem::path& directory, const RunFacts& facts, const Simulation& simulation,
                        const Recording& recording);

/// A scene at rest, for its page and its picture.
struct Rest {
  std::string scene, said;  ///< its name; what was found, in a line
  std::vector<std::string> warnings, left_out;
  std::optional<Cell> cell;
  std::span<const Observed> observed;
  tanor::Solution state;         ///< positions and forces
  const Modes* modes = nullptr;  ///< small vibrations about it; null: none
};

/// Writes `directory/report.html` of a scene at rest: loads and tensions, and modes that swing.
void write_rest_page(const std::filesystem::path& directory, const System& system, const Rest& rest);

}  // namespace tanor::report
