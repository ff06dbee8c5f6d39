#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "report/guides.hpp"

namespace tanor::report {

/// One instant of a motion as a trajectory shows it: rows of m points and R rods, in their order in ShownParts.
struct Frame {
  std::size_t number = 0;                                     ///< 0, 1, … in the trajectory
  std::size_t steps = 0;                                      ///< of the method until then
  double time = 0.0;                                          ///< s
  std::span<const double> positions{};                        ///< 3m, m
  std::span<const double> velocities{};                       ///< 3m, m/s
  std::span<const double> accelerations{};                    ///< 3m, m/s^2
  std::span<const double> forces{};                           ///< 3m, N: M w
  std::span<const double> reactions{};                        ///< 3m, N: K lambda
  std::span<const double> tensions{};                         ///< R, N: -lambda
  std::span<const double> guide_forces{};                     ///< 3m, N; empty where no point is held
  std::span<const double> friction_forces{};                  ///< 3m, N; empty where there is no friction
  std::vector<Guide> guides{};                                ///< where they stand now
  Vector3 gravity{};                                          ///< m/s^2
  double energy = 0.0;                                        ///< J, kinetic and potential
  double position_violation = 0.0, velocity_violation = 0.0;  ///< largest so far, relative
};

/// A file, or several, that frames are appended to.
///
/// Whenever the program stops, what is there can be read: a frame is in it as a whole, or not at all.
class FrameFile {
 public:
  virtual ~FrameFile() = default;

  /// Throws WriteError; a `cut` to the mark before makes the file what it was.
  virtual void write(const Frame& frame) = 0;
  /// How far it is written, in bytes or in frames; not 0 once there is a frame.
  virtual std::uint64_t mark() const = 0;
  /// Takes it back to an earlier mark, that before the last frame.
  virtual void cut(std::uint64_t mark) = 0;
  /// Makes all frames outlive the program and, where the format can, the machine. Throws WriteError.
  virtual void synchronize() = 0;
};

}  // namespace tanor::report
