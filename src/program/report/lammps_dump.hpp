#pragma once

#include <optional>

#include "report/shown_parts.hpp"
#include "report/text_trajectory.hpp"

namespace tanor::report {

/// Writes a LAMMPS dump (for its read_dump, OVITO, ASE): id (the number of the point plus 1), type (1: moving, 2:
/// support), positions, velocities, and the force M w on each point, with 10 significant digits. In a periodic cell
/// positions are unwrapped. The time step is the number of the frame; the time stands above it.
class LammpsDump : public TextTrajectory {
 public:
  /// `shown` must outlive this object. `mark` is 0 for a new file.
  LammpsDump(const std::filesystem::path& path, const ShownParts* shown, const std::optional<Cell>& cell,
             std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;

  const ShownParts* shown_;
  std::optional<Cell> cell_;
};

/// Writes a LAMMPS "dump local" (OVITO reads it as bonds): both ids of each rod, its length and its tension.
class LammpsRodDump : public TextTrajectory {
 public:
  LammpsRodDump(const std::filesystem::path& path, const ShownParts* shown, const std::optional<Cell>& cell,
                std::uint64_t mark = 0);

 private:
  void print(const Frame& frame, fmt::memory_buffer* text) const override;

  const ShownParts* shown_;
  std::optional<Cell> cell_;
};

}  // namespace tanor::report
