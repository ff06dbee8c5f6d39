#pragma once

#include <filesystem>
#include <string_view>

#include "report/recording.hpp"
#include "report/summary.hpp"

namespace tanor::report {

/// The page without a run, as src/report/page makes it; empty where the program was built without node.
std::string_view html_page_template();
inline bool has_html_page() {
  return !html_page_template().empty();
}

inline constexpr const char* html_page_name = "report.html";

/// Writes `directory/report.html`, which needs nothing else: the facts of a run, its motion and its histories. A table
/// `error_time.csv` that lies there already is shown too.
void write_html_page(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation,
                     const Recording& recording);
/// The same of a run that goes on. It asks the simulation for nothing that is not known yet.
void write_running_page(const std::filesystem::path& directory, const RunFacts& facts, const Simulation& simulation,
                        const Recording& recording);

}  // namespace tanor::report
