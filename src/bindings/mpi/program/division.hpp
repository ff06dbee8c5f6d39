#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "mpi/tanor_mpi.hpp"
#include "scene/scene.hpp"

namespace tanor::mpi {

/// Numbers of things in the system of all ranks.
struct Counts {
  std::size_t points = 0, supports = 0, equations = 0, islands = 0, contacts = 0;
};

/// The system of a run, divided over the ranks.
class Division {
 public:
  /// Divides the system of a scene that every rank has read.
  static Division divide(MpiRanks& ranks, scene::Scene scene);
  /// Makes one system of the scenes that the ranks have, each its own; no rank holds that system.
  static Division join(MpiRanks& ranks, scene::Scene own);

  /// The scene that this rank has read, without its system if the ranks have scenes of their own.
  const scene::Scene& scene() const { return scene_; }
  const RankSystem& part() const { return part_; }
  const Counts& counts() const { return counts_; }
  /// Returns the whole system, or null if no rank holds it.
  const System* whole() const { return has_whole_ ? &scene_.system : nullptr; }

  /// The mark of the run's scenes, by which a checkpoint is known; the same on every rank.
  const std::string& mark() const { return mark_; }
  /// Says how the mark of another run differs from this one.
  std::string name_difference(std::string_view before) const;
  void write_checkpoint(const std::filesystem::path& name, const Simulation& simulation) const;
  void read_checkpoint(const std::filesystem::path& name, Simulation* simulation) const;

 private:
  Division(MpiRanks& ranks, scene::Scene scene) : ranks_(ranks), scene_(std::move(scene)) {}

  MpiRanks& ranks_;
  scene::Scene scene_;
  std::string mark_;
  Counts counts_;
  RankSystem part_;
  bool has_whole_ = true;
};

}  // namespace tanor::mpi
