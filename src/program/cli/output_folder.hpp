#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/folder_lock.hpp"

namespace tanor::cli {

/// Returns where a command writes: --out, else the name of the scene's file with another ending. The state of rest in
/// net.equilibrium.out has the name net.at_rest, since all such files have one name.
std::filesystem::path choose_folder(const std::optional<std::filesystem::path>& out, const std::filesystem::path& scene,
                                    const char* ending = ".out");

/// The folder of a command's results. It is made and held before anything is computed, and removed if nothing came of
/// it.
class OutputFolder {
 public:
  /// Throws as FolderLock does, and WriteError if no folder can be made.
  OutputFolder(std::filesystem::path path, const std::string& command);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  bool is_new_;
  std::optional<FolderLock> lock_;
};

/// Throws InputError if a run has left what it needs to go on; only another run may begin anew there.
void require_no_run(const std::filesystem::path& folder, const std::string& command);

/// The files that tanor-mpi writes beside a summary.
inline constexpr const char *mpi_checkpoint_name = "checkpoint.mpi", *mpi_trajectory_name = "trajectory.npy",
                            *mpi_times_name = "trajectory_times.npy";

/// Throws InputError if a command would replace a file that it has read: by a result of its own, or among the results
/// that it removes from its folder.
void require_not_read(const std::filesystem::path& result, const std::vector<std::filesystem::path>& read);
void require_results_not_read(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& read);

/// True if any results are in a folder.
bool holds_results(const std::filesystem::path& folder);

/// Removes what an earlier `run` (tanor's or tanor-mpi's), `equilibrium` or `modes` has left, and nothing else, since
/// it could not be told from the new results. The scene at rest, equilibrium.json, stays, because it is a scene to go
/// on from.
void remove_results(const std::filesystem::path& folder);

}  // namespace tanor::cli
