#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <type_traits>
#include <vector>

#include <tanor/motion.hpp>

#include "base/archive.hpp"
#include "report/guides.hpp"
#include "report/shown_parts.hpp"
#include "report/thinned_list.hpp"

namespace tanor::report {

/// One instant of a motion as its view shows it.
struct RecordedFrame {
  double time = 0.0;
  std::vector<float> positions;             ///< 3m, m, of the shown points
  std::vector<float> tensions;              ///< N, of the shown rods
  std::vector<float> normal_reactions;      ///< 3h, N: what guides and supports do to the held points
  std::vector<float> tangent_reactions;     ///< 3h, N: friction there; empty: the system has none
  std::vector<std::vector<double>> guides;  ///< numbers of each Guide
};

/// Its parts, to write it and to read it back (base/archive.hpp).
template <class Frame, class Visit>
void visit_parts(Frame& frame, Visit& visit) requires std::is_same_v<std::remove_const_t<Frame>, RecordedFrame> {
  visit(frame.time, frame.positions, frame.tensions, frame.normal_reactions, frame.tangent_reactions, frame.guides);
}

/// What the report says of one step; of violations and the condition the worst one until the next step that is kept.
struct RecordedStep {
  double time = 0.0, step = 0.0;
  double energy = 0.0, kinetic = 0.0, potential = 0.0, drift = 0.0;
  double position_violation = 0.0, velocity_violation = 0.0, acceleration_violation = 0.0;
  double reciprocal_condition = 0.0;
  double friction_iterations = 0.0;  ///< mean of the instants since the sample before
};

inline void absorb(RecordedStep* kept, const RecordedStep& later) {
  kept->position_violation = std::max(kept->position_violation, later.position_violation);
  kept->velocity_violation = std::max(kept->velocity_violation, later.velocity_violation);
  kept->acceleration_violation = std::max(kept->acceleration_violation, later.acceleration_violation);
  kept->reciprocal_condition = std::min(kept->reciprocal_condition, later.reciprocal_condition);
}

}  // namespace tanor::report
template <>
inline constexpr bool tanor::is_plain_bytes<tanor::report::RecordedStep> = true;
namespace tanor::report {

/// When a run writes frames: at the start, every so many seconds (0: never), and at the end.
struct OutputTimes {
  double start = 0.0;     ///< s; of the motion, however often it was resumed
  double duration = 0.0;  ///< s
  double every = 0.0;     ///< s
};

/// Holds what a recording has taken.
struct Recorded {
  ThinnedList<RecordedFrame> frames;
  ThinnedList<RecordedStep> steps;
  std::vector<double> switches;   ///< s, the first ones, the last one of a step
  std::size_t events_before = 0;  ///< of the motion, before the recording began
};

/// Keeps what a page needs of a motion while it runs. Where there are more frames or steps than the page has room for,
/// every second one goes, again and again, and the last one stays. Where output times are too rare for a smooth
/// picture, it asks for instants between them.
class Recording {
 public:
  Recording(const System& system, std::span<const Index> chosen, OutputTimes times = {});

  /// At an output time. `friction`: 3n, N; empty: the system has none.
  void take_frame(const Simulation& simulation, std::span<const double> friction = {});
  /// Whether a frame between two output times is due.
  bool wants_frame(double time) const { return time >= next_frame_; }
  void take_frame(const System& system, const Solution& between, std::span<const double> friction = {});
  void take_step(const MotionReport& report);
  /// Goes on after a part of the motion that ended at or after the simulation's time. False: it is of other points or
  /// guides, and is not taken.
  bool go_on(Recorded before, const Simulation& simulation);

  const ShownParts& shown() const { return shown_; }
  const std::vector<std::int32_t>& held() const { return held_; }  ///< positions among the shown points
  const std::vector<Guide>& guides() const { return guides_; }     ///< at the first frame
  const Recorded& recorded() const { return recorded_; }
  std::vector<RecordedFrame> frames() const { return recorded_.frames.items(); }
  std::vector<RecordedStep> steps() const { return recorded_.steps.items(); }
  /// When the equations changed: a contact began or ceased to slip, s; the last one of a step, of the first 500 steps.
  const std::vector<double>& switches() const { return recorded_.switches; }
  /// All of them since the recording began.
  std::size_t num_switches() const { return events_ - recorded_.events_before; }
  std::size_t frames_seen() const { return recorded_.frames.num_seen(); }

 private:
  /// A state of the motion with its forces.
  struct Instant {
    StateView state;
    std::span<const double> multipliers, reactions, support_forces, friction;
  };
  void take(const System& system, const Instant& instant);
  bool fits(const RecordedFrame& frame) const;
  RecordedFrame record(const System& system, const Instant& instant);
  void add_reactions(const Instant& instant, RecordedFrame* frame);

  ShownParts shown_;
  std::vector<std::int32_t> held_;
  std::vector<Guide> guides_;
  double t_start_ = 0.0;                                         ///< s
  double frame_interval_ = 0.0;                                  ///< s, between two frames that are wanted
  double next_frame_ = std::numeric_limits<double>::infinity();  ///< s, before the next output time; infinity: none
  Recorded recorded_;
  std::size_t events_ = 0, friction_solves_ = 0;
  double friction_iterations_ = 0.0;
};

}  // namespace tanor::report
