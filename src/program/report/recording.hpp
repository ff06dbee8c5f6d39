#pragma once

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include <tanor/motion.hpp>

#include "base/archive.hpp"
#include "report/guides.hpp"
#include "report/shown_parts.hpp"
#include "report/thinned_list.hpp"

namespace tanor::report {
using namespace detail;

/// One instant of a motion as the page shows it.
struct RecordedFrame {
  double time = 0.0;
  std::vector<float> positions;             ///< 3m, m, of the shown points
  std::vector<float> tensions;              ///< N, of the shown rods
  std::vector<float> tie_tensions;          ///< N, of the shown ties
  std::vector<float> normal_reactions;      ///< 3h, N: forces of guides and supports on the held points
  std::vector<float> tangent_reactions;     ///< 3h, N: friction there; empty if the system has none
  std::vector<std::vector<double>> guides;  ///< numbers of each Guide
  std::vector<double> observed;             ///< numbers of the observables that have few, one after the other
};

/// Returns true if an observable has few enough numbers for curves over time.
inline bool is_recorded(const Observed& observed) {
  constexpr std::size_t most_curves = 64;
  return observed.values.size() <= most_curves;
}

/// Visits all parts, to write and to read them (base/archive.hpp).
template <class Frame, class Visit>
void visit_parts(Frame& frame, Visit& visit) requires std::is_same_v<std::remove_const_t<Frame>, RecordedFrame> {
  visit(frame.time, frame.positions, frame.tensions, frame.tie_tensions, frame.normal_reactions,
        frame.tangent_reactions, frame.guides, frame.observed);
}

/// An instant at which the equations changed.
struct RecordedChange {
  double time = 0.0;  ///< s
  std::string what;   ///< which contact sticks or slips from then on

  bool operator==(const RecordedChange&) const = default;
};
template <class Change, class Visit>
void visit_parts(Change& change, Visit& visit) requires std::is_same_v<std::remove_const_t<Change>, RecordedChange> {
  visit(change.time, change.what);
}

/// The report of one step. Violations and the condition number are the worst ones until the next recorded step.
struct RecordedStep {
  double time = 0.0, step = 0.0;
  double energy = 0.0, kinetic = 0.0, potential = 0.0, drift = 0.0;
  double position_violation = 0.0, velocity_violation = 0.0, acceleration_violation = 0.0;
  double reciprocal_condition = 0.0;
  double friction_iterations = 0.0;  ///< mean over the instants since the sample before
};

inline void absorb(RecordedStep* kept, const RecordedStep& later) {
  kept->position_violation = std::max(kept->position_violation, later.position_violation);
  kept->velocity_violation = std::max(kept->velocity_violation, later.velocity_violation);
  kept->acceleration_violation = std::max(kept->acceleration_violation, later.acceleration_violation);
  kept->reciprocal_condition = std::min(kept->reciprocal_condition, later.reciprocal_condition);
}

}  // namespace tanor::report
template <>
inline constexpr bool tanor::detail::is_plain_bytes<tanor::report::RecordedStep> = true;
namespace tanor::report {

/// The times at which a run writes frames: at the start, every `every` seconds (0: never), and at the end.
struct OutputTimes {
  double start = 0.0;     ///< s; start of the motion, however often it was resumed
  double duration = 0.0;  ///< s
  double every = 0.0;     ///< s
};

/// Everything that was recorded.
struct Recorded {
  ThinnedList<RecordedFrame> frames;
  ThinnedList<RecordedStep> steps;
  std::vector<RecordedChange> switches;  ///< the first ones; of each step the last one
  std::size_t events_before = 0;         ///< events of the motion before the recording began
};

/// Records what a page needs of a motion while it runs. If there are more frames or steps than the page has room for,
/// every second one is dropped repeatedly, but the last one stays. If output times are too rare for a smooth picture,
/// the recording requests instants between them.
class Recording {
 public:
  Recording(const System& system, std::span<const Index> chosen, OutputTimes times = {});

  /// Takes a frame at an output time. `friction` is 3n, N, and empty if the system has none.
  void take_frame(const Simulation& simulation, std::span<const double> friction = {},
                  std::span<const Observed> observables = {});
  /// Returns true if a frame between two output times is due.
  bool wants_frame(double time) const { return time >= next_frame_; }
  void take_frame(const System& system, const Solution& between, std::span<const double> friction = {},
                  std::span<const Observed> observables = {});
  void take_step(const MotionReport& report);
  /// Continues a part of the motion that ended at or after the simulation's time. Returns false, and does not take it,
  /// if it belongs to other points or guides.
  bool go_on(Recorded before, const Simulation& simulation);

  const ShownParts& shown() const { return shown_; }
  const std::vector<std::int32_t>& held() const { return held_; }  ///< positions among the shown points
  const std::vector<Guide>& guides() const { return guides_; }     ///< at the first frame
  double t_start() const { return t_start_; }
  std::vector<Guide> guides_without_picture(const System& system) const {
    return list_guides_without_picture(system, shown_, t_start_);
  }
  const Recorded& recorded() const { return recorded_; }
  /// Returns the observables with their numbers in the last frame.
  const std::vector<Observed>& observables() const { return observables_; }
  std::vector<RecordedFrame> frames() const { return recorded_.frames.items(); }
  std::vector<RecordedStep> steps() const { return recorded_.steps.items(); }
  std::vector<double> tensions() const;  ///< N, of all shown rods in all frames
  /// Returns where the equations changed because a contact began or ceased to slip: the last change of a step, for the
  /// first 500 such steps.
  const std::vector<RecordedChange>& switches() const { return recorded_.switches; }
  /// Returns the number of all events since the recording began.
  std::size_t num_switches() const { return events_ - recorded_.events_before; }
  std::size_t frames_seen() const { return recorded_.frames.num_seen(); }

 private:
  /// A state of the motion with its forces.
  struct Instant {
    StateView state;
    std::span<const double> multipliers, reactions, support_forces, friction, self_stress;
    std::span<const Observed> observables;
  };
  void take(const System& system, const Instant& instant);
  bool fits(const RecordedFrame& frame) const;
  RecordedFrame record(const System& system, const Instant& instant);
  void add_reactions(const Instant& instant, RecordedFrame* frame);

  ShownParts shown_;
  std::vector<std::int32_t> held_;
  std::vector<Guide> guides_;
  double t_start_ = 0.0;         ///< s
  double frame_interval_ = 0.0;  ///< s, interval of the frames that are requested
  double next_frame_ =
      std::numeric_limits<double>::infinity();  ///< s, before the next output time; infinity if none is requested
  Recorded recorded_;
  std::vector<Observed> observables_;
  std::size_t events_ = 0, friction_solves_ = 0;
  double friction_iterations_ = 0.0;
};

inline constexpr const char* recording_name = "recording";

/// Replaces `directory/recording`, with which the page of a resumed run begins. The file has a line with the format's
/// number, the fingerprint, the time and everything recorded, and a line with the checksum of everything before.
void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording);

/// Takes what an earlier part of the run recorded until the simulation's time. Returns false if there is no file, or if
/// it is damaged, of another run, or of an earlier time. The page then begins where the run was resumed, and nothing
/// else is lost.
bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording);

}  // namespace tanor::report
