#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <tanor/system.hpp>

namespace tanor::scene {

/// The positions of points at one time, read from a file that another program made.
struct ReferenceState {
  std::string name;               ///< name of the file
  std::vector<Index> points;      ///< points in the file: all, or all except supports
  std::vector<double> positions;  ///< 3n, m; 0 for other points
};

/// Reads the state at time t, s, of a system from
/// - a text of blocks: a line with the time, then a line x y z (vx vy vz) for each point; '#' begins a remark;
/// - `.json`: {"dim": 2 | 3, "trajectory": [{"t": "1", "r": ["0.1", …]}, …]}, numbers as such or as text.
/// Throws InputError if the file cannot be read, has no such time, or has other points than the system.
ReferenceState read_reference_state(const std::filesystem::path& file, const System& system, double t);

}  // namespace tanor::scene
