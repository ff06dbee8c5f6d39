#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

#include "mpi/tanor_mpi.hpp"
#include "scene/scene.hpp"

namespace tanor::mpi {

/// Returns "melt.json" of "melt-{rank}.json": the name without the rank and the sign that set it apart.
std::filesystem::path name_run(const std::filesystem::path& name);

/// The system of a run, divided over the ranks.
class Division {
 public:
  using ReadScene = std::function<scene::Scene(const std::filesystem::path&)>;
  /// Divides the system of a scene that every rank reads. If the name has "{rank}" in it, which stands for a number,
  /// each rank reads a scene of its own, and no rank holds the system that they make. Collective.
  Division(MpiRanks& ranks, const std::filesystem::path& name, const ReadScene& read);

  /// The scene that this rank has read, without its system if the ranks have scenes of their own.
  const scene::Scene& scene() const { return scene_; }
  const RankSystem& part() const { return part_; }
  /// Returns the number of points of all ranks.
  std::size_t num_points() const { return num_points_; }
  /// Returns the whole system, or null if no rank holds it.
  const System* whole() const { return has_whole_ ? &scene_.system : nullptr; }

  /// The mark of the run's scenes, by which a checkpoint is known; the same on every rank.
  const std::string& mark() const { return mark_; }
  /// Says how the mark of another run differs from this one.
  std::string name_difference(std::string_view before) const;

 private:
  void divide(const std::filesystem::path& name, const ReadScene& read);
  void join(const std::filesystem::path& name, const ReadScene& read);

  MpiRanks& ranks_;
  scene::Scene scene_;
  std::string mark_;
  RankSystem part_;
  std::size_t num_points_ = 0;
  bool has_whole_ = true;
};

}  // namespace tanor::mpi
