#pragma once

#include <filesystem>
#include <vector>

#include "report/motion_extent.hpp"
#include "report/stored_frame.hpp"
#include "report/vtp_reader.hpp"

namespace tanor::report {

/// What `tanor picture` writes into the folder of a run where it is not told otherwise.
inline constexpr const char* picture_name = "picture.png";

/// The motion that a run has left in its folder (`trajectory.pvd`), at any time. A run that goes on may be read too.
class StoredMotion {
 public:
  /// Throws InputError where the folder holds no frames.
  explicit StoredMotion(const std::filesystem::path& directory);

  double begin() const { return frames_.front().time; }
  double end() const { return frames_.back().time; }

  /// An instant, and the times of the frames that it was found from: the same twice where it is one of them.
  struct Instant {
    StoredFrame frame;
    double before = 0.0, after = 0.0;  ///< s
  };
  /// Between frames positions follow the cubic polynomial through both positions and velocities (Hermite's; its error
  /// is of fourth order in the distance of the frames), forces and numbers of guides straight lines.
  /// `time` must lie between begin() and end().
  Instant at(double time) const;

  /// Of frames all over the motion.
  MotionExtent measure() const;

 private:
  std::vector<ListedFrame> frames_;
};

}  // namespace tanor::report
