#pragma once

#include <filesystem>
#include <vector>

#include "mpi/tanor_mpi.hpp"

/// \file Frames of positions that all ranks write together: `trajectory.npy`, [frame][point][3], m, and
/// `trajectory_times.npy`, [frame], s.
namespace tanor::mpi {

/// Returns the times of the frames that a folder has up to `time`, s.
std::vector<double> read_frame_times(const std::filesystem::path& folder, double time);

/// Writes the present state of all `num_points` points behind the frames at these times, and adds its own. The disk
/// then has both files completely. Collective.
void write_frame(MpiRanks& ranks, const std::filesystem::path& folder, const RankSystem& part, std::size_t num_points,
                 const Simulation& simulation, std::vector<double>* times);

}  // namespace tanor::mpi
