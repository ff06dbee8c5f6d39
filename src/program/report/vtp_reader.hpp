#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "report/guides.hpp"

namespace tanor::report {

/// Largest accepted coordinate, m, and velocity, m/s, so that squares of distances do not overflow.
inline constexpr double largest_place = 1e150;

/// One instant of a motion as it is read from a folder of results: rows of m points, in which the ends of periodic rods
/// follow the points that a run shows, and of R rods.
struct StoredFrame {
  double time = 0.0;                                 ///< s; NaN at rest
  std::vector<double> positions;                     ///< 3m, m
  std::vector<double> velocities;                    ///< 3m, m/s
  std::vector<bool> is_support;                      ///< m, of those that hold at this time
  std::vector<double> rods_gone{}, supports_gone{};  ///< R, m: since when, s; NaN where they hold; empty if all do
  std::vector<std::array<std::int32_t, 2>> rods;     ///< rows of their ends
  std::vector<double> tensions;                      ///< R, N
  std::vector<double> guide_forces;       ///< 3m, N: forces of guides and supports; empty if no point is held
  std::vector<double> friction_forces{};  ///< 3m, N; empty if there is no friction
  std::vector<Guide> guides;
  Vector3 gravity{};                      ///< m/s^2; 0 if there is none
  std::string time_unit{}, force_unit{};  ///< empty without letters

  std::size_t num_points() const { return is_support.size(); }
};

/// Takes rods, supports and guides that went until the time of a frame out of it.
void leave_out_gone(StoredFrame* frame);

/// Reads a frame that `write_vtp` has written. Throws InputError, naming the file, if it is damaged or another
/// program's.
StoredFrame read_vtp(const std::filesystem::path& path);

struct ListedFrame {
  double time = 0.0;           ///< s
  std::filesystem::path file;  ///< the frame's file
};

/// Reads the list of frames that `VtpTrajectory` writes, in the order of time. Throws InputError as `read_vtp` does.
std::vector<ListedFrame> read_frame_list(const std::filesystem::path& path);

}  // namespace tanor::report
