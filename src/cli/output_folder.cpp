#include "cli/output_folder.hpp"

#include "report/checkpoint.hpp"
#include "report/html_page.hpp"
#include "report/output_file.hpp"
#include "report/page.hpp"
#include "report/stored_motion.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::cli {

void remove_results(const std::filesystem::path& folder) {
  report::remove_checkpoint(folder);
  report::remove_trajectory(folder);
  report::remove_summary(folder);
  for (const char* name : {report::page_name, report::html_page_name, report::picture_name})
    report::remove_file(folder / name);
  for (const char* name : {mpi_checkpoint_name, mpi_trajectory_name, mpi_times_name})
    report::remove_file(folder / name);
}

}  // namespace tanor::cli
