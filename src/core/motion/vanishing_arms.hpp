#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/root_isolation.hpp"
#include "base/vec3.hpp"
#include "motion/dense_output.hpp"
#include "motion/scheme.hpp"

namespace tanor::detail {

/// Finds where a vector vanishes along which the equations need a direction, as a part of a rope that has run through
/// its wheel. The equations end there, but a step along a straight line may jump over it, and see nothing.
class VanishingArms {
 public:
  struct Arms {
    std::size_t count = 0;
    std::function<void(const Kinematics& at, Vec3* vectors)> evaluate;  ///< m [count]
    /// Returns the distance of an arm's ends from the origin, m, beside which its rounding is small.
    std::function<double(const Kinematics& at, std::size_t k)> size;
    /// Returns the length that a function of time gives an arm, m; infinity if none does.
    std::function<double(double t, std::size_t k)> given_length;
    std::function<std::string(std::size_t k)> name;
  };

  VanishingArms(const IntegrationOptions& options, Mechanics& mechanics);
  /// Looks for these from now on. All processes must call this, with their own.
  void watch(Arms arms);
  /// Returns true if no process has any.
  bool is_empty() const { return is_empty_; }

  /// The first arm that vanishes.
  struct Found {
    double time;                     ///< s, as long as it is only a prediction
    std::optional<std::size_t> own;  ///< its number, on the process that has it
    Vec3 direction;                  ///< its direction where it was looked for
  };
  /// Looks through a good step. The mechanics stays where it is.
  std::optional<Found> find(Scheme& scheme, const State& from, const State& to);
  /// Returns true if an arm is so short that a step from one state to the other may have passed its end unseen.
  bool are_short(const State& from, const State& to);
  /// Looks within so many seconds, by the velocities of a state, and its accelerations if they are known. An arm that
  /// is too short for its direction to be known is found whenever it vanishes.
  std::optional<Found> find_ahead(const State& state, bool knows_acceleration, double within);
  /// Returns the time in which the arm vanishes from a state, s, by its velocity, and its acceleration if that is
  /// known. It is not finite if the arm does not, and negative if it has vanished before.
  double time_left(const Found& arm, const State& state, bool knows_acceleration);
  /// Returns true if the arm is too short for its direction to be known.
  bool is_unresolved(const Found& arm, const State& state);
  /// Returns the rounding of the time in which the arm vanishes, s: that of its length over its rate.
  double rounding_of_time(const Found& arm, const State& state);
  /// Returns "rope[0]: the part from b to point 1 has run out at t = 0.5".
  Outcome explain(const Found& arm, double t) const;

 private:
  struct Path;
  double when_given_ends(std::size_t k, double t, double within) const;
  const std::vector<Vec3>& evaluate(const Kinematics& at);
  const std::vector<Vec3>& evaluate_ahead(const State& state, double by_v, double by_a);
  std::optional<Found> examine(const Path& path, std::size_t k);
  std::optional<Found> agree(const Found& first);
  double nearest(const State& from, std::size_t k, double length) const;

  Mechanics& mechanics_;
  const double miss_;  // by which the motion may miss the place where an arm vanishes, over the distance of its ends
  Arms arms_;
  bool is_empty_ = true;
  std::vector<std::vector<Vec3>> samples_;  // [place][arm]
  std::vector<Vec3> vectors_;
  std::vector<double> x_, v_;
  RootIsolation isolation_;
};

}  // namespace tanor::detail
