#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "report/motion_extent.hpp"
#include "report/vtp_reader.hpp"

namespace tanor::report {

/// File that `tanor picture` writes into the folder of a run by default.
inline constexpr const char* picture_name = "picture.png";

/// Returns why the run in a folder ended before its time, as its summary says, or nothing.
std::string read_stop(const std::filesystem::path& directory);

/// The motion that a run has stored in its folder (`trajectory.pvd`), at any time. A run that goes on may be read too.
class StoredMotion {
 public:
  /// Takes the motion, or the period of a mode, from 1. Throws InputError if the folder holds no frames of it.
  explicit StoredMotion(const std::filesystem::path& directory, int mode = 0);

  double begin() const { return frames_.front().time; }
  double end() const { return frames_.back().time; }

  /// An instant, and the times of the frames around it, which are equal if it is one of them.
  struct Instant {
    StoredFrame frame;
    double before = 0.0, after = 0.0;  ///< s
  };
  /// Returns an instant between begin() and end(). Between frames positions follow Hermite's cubic polynomial through
  /// the positions and velocities of both, whose error is of fourth order in the distance of the frames. Forces and the
  /// numbers of guides are interpolated linearly.
  Instant at(double time) const;

  /// Measures frames spread over the motion, with the guides or without. The colours are those of the run's
  /// report.html, if it has one.
  MotionExtent measure(bool with_guides = true) const;

 private:
  std::filesystem::path directory_;
  std::vector<ListedFrame> frames_;
};

}  // namespace tanor::report
