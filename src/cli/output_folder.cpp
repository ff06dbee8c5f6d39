#include "cli/output_folder.hpp"

#include <fmt/format.h>

#include <system_error>
#include <utility>

#include <tanor/error.hpp>

#include "cli/messages.hpp"
#include "report/checkpoint.hpp"
#include "report/equilibrium.hpp"
#include "report/html_page.hpp"
#include "report/modes.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/recording_file.hpp"
#include "report/stored_motion.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

OutputFolder::OutputFolder(fs::path path, const std::string& command)
    : path_(std::move(path)), is_new_(!fs::exists(path_)) {
  report::make_folder(path_);
  lock_.emplace(path_, command);
}

OutputFolder::~OutputFolder() {
  lock_.reset();
  std::error_code is_filled;
  if (is_new_) fs::remove(path_, is_filled);
}

void require_no_run(const fs::path& folder, const std::string& command) {
  for (const char* name : {report::checkpoint_name, mpi_checkpoint_name}) {
    if (!fs::exists(folder / name)) continue;
    throw InputError(folder.string(), fmt::format("has the results of a run, which tanor {} would replace; choose "
                                                  "another folder with --out, or remove {}",
                                                  command, typed(folder / name)));
  }
}

void remove_results(const std::filesystem::path& folder) {
  report::remove_checkpoint(folder);
  report::remove_trajectory(folder);
  report::remove_summary(folder);
  report::remove_equilibrium(folder);
  report::remove_modes(folder);
  for (const char* name : {report::recording_name, report::page_name, report::html_page_name, report::picture_name})
    report::remove_file(folder / name);
  for (const char* name : {mpi_checkpoint_name, mpi_trajectory_name, mpi_times_name})
    report::remove_file(folder / name);
}

}  // namespace tanor::cli
