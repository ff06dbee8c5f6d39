#include "cli/output_folder.hpp"

#include <fmt/format.h>

#include <string_view>
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
#include "report/recording.hpp"
#include "report/stored_motion.hpp"
#include "report/summary.hpp"
#include "report/trajectory.hpp"

namespace tanor::cli {

namespace fs = std::filesystem;

fs::path choose_folder(const std::optional<fs::path>& out, const fs::path& scene, const char* ending) {
  constexpr std::string_view of_rest = ".equilibrium.out";
  if (out) return *out;
  std::string name = scene.stem().string(), folder = fs::absolute(scene).parent_path().filename().string();
  if (scene.filename() == report::scene_at_rest_name && folder.ends_with(of_rest))
    name = folder.erase(folder.size() - of_rest.size()) + ".at_rest";
  if (name.starts_with('.')) name[0] = '_';  // nobody would find a hidden folder
  return name + ending;
}

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

namespace {

/// Lists what `run` (tanor's or tanor-mpi's), `equilibrium` or `modes` may leave in a folder, except the scene at rest.
std::vector<fs::path> list_results(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const char* name :
       {report::checkpoint_name, report::recording_name, report::page_name, report::html_page_name,
        report::picture_name, report::places_at_rest_name, mpi_checkpoint_name, mpi_trajectory_name, mpi_times_name})
    files.push_back(folder / name);
  for (const auto& list : {report::list_trajectory(folder), report::list_summary(folder), report::list_modes(folder)})
    files.insert(files.end(), list.begin(), list.end());
  return files;
}

}  // namespace

bool holds_results(const fs::path& folder) {
  std::error_code error;  // a file that cannot be asked about counts as absent
  return std::ranges::any_of(list_results(folder), [&](const fs::path& file) { return fs::exists(file, error); });
}

void require_not_read(const fs::path& result, const std::vector<fs::path>& read) {
  std::error_code error;  // a file that does not exist was not read
  for (const fs::path& file : read) {
    if (fs::equivalent(result, file, error))
      throw InputError(file.string(),
                       "is read by this command, which would replace it; choose another place with --out");
  }
}

void require_results_not_read(const fs::path& folder, const std::vector<fs::path>& read) {
  const std::vector<fs::path> results = list_results(folder);
  for (const fs::path& file : read) {
    std::error_code error;
    const fs::path name = fs::canonical(file, error).filename();
    const bool has_other_names = fs::hard_link_count(file, error) > 1 && !error;
    for (const fs::path& result : results) {  // a run may have left many frames, and few have this name
      if (has_other_names || result.filename() == name || result.filename() == file.filename())
        require_not_read(result, {file});
    }
  }
}

void remove_results(const fs::path& folder) {
  for (const fs::path& file : list_results(folder)) {
    report::remove_file(file);
    std::error_code error;  // the folder of frames has more of them, or is gone
    if (!fs::equivalent(file.parent_path(), folder, error)) fs::remove(file.parent_path(), error);
  }
}

}  // namespace tanor::cli
