#include "report/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "base/archive.hpp"
#include "report/output_file.hpp"
#include "report/shown_parts.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace {

constexpr std::size_t most_steps = 4000, most_switches = 500;
/// Bytes of a page's frames before they are packed; packing saves about as much as base64 costs.
constexpr std::size_t room_for_frames = 9'000'000, most_frames_ever = 1500;
/// Number of frames with which a motion looks smooth; those between output times take at most `room_between` bytes.
constexpr std::size_t smooth_frames = 150, room_between = 3'000'000;

std::vector<std::int32_t> list_held(const System& system, const ShownParts& shown) {
  const std::vector<bool> is_held = find_held_points(system);
  std::vector<std::int32_t> result;
  for (std::size_t k = 0; k < shown.num_points; ++k) {
    if (is_held[static_cast<std::size_t>(shown.points[k])]) result.push_back(static_cast<std::int32_t>(k));
  }
  return result;
}

/// Returns the bytes of a frame.
std::size_t bytes_of_frame(const ShownParts& shown, std::size_t num_held) {
  return 6 * shown.num_points + 2 * shown.rods.size() + 12 * num_held + 1;
}

}  // namespace

Recording::Recording(const System& system, std::span<const Index> chosen, OutputTimes times)
    : shown_(choose_parts(system, chosen)),
      held_(list_held(system, shown_)),
      t_start_(times.start),
      recorded_{.frames = ThinnedList<RecordedFrame>(std::clamp<std::size_t>(
                    room_for_frames / bytes_of_frame(shown_, held_.size()), 2, most_frames_ever)),
                .steps = ThinnedList<RecordedStep>(most_steps),
                .switches = {},
                .events_before = 0} {
  const double each = times.every > 0.0 ? std::min(times.every, times.duration) : times.duration;
  const std::size_t wanted = std::min(smooth_frames, room_between / bytes_of_frame(shown_, held_.size()));
  const double parts = std::floor(static_cast<double>(wanted) * (each / times.duration));
  constexpr double rounding =
      1e-9;  // relative error of times, so that the step that just reaches the next one does not miss it
  if (parts > 1.0) frame_interval_ = (1.0 - rounding) * each / parts;
}

void Recording::take_frame(const Simulation& simulation, std::span<const double> friction,
                           std::span<const Observed> observables) {
  const std::vector<double> self_stress = simulation.self_stress();
  take(
      simulation.system(),
      {.state = {.time = simulation.time(), .positions = simulation.positions(), .velocities = simulation.velocities()},
       .multipliers = simulation.multipliers(),
       .reactions = simulation.reactions(),
       .support_forces = simulation.support_forces(),
       .friction = friction,
       .self_stress = self_stress,
       .observables = observables});
  if (recorded_.steps.is_empty()) take_step(simulation.report());  // so that histories begin at the start
}

void Recording::take_frame(const System& system, const Solution& between, std::span<const double> friction,
                           std::span<const Observed> observables) {
  take(system, {.state = between.state(),
                .multipliers = between.multipliers,
                .reactions = between.reactions,
                .support_forces = between.support_forces,
                .friction = friction,
                .self_stress = between.self_stress,
                .observables = observables});
}

void Recording::take(const System& system, const Instant& instant) {
  observables_.assign(instant.observables.begin(), instant.observables.end());
  // A resumed run stands at a frame that may already have been recorded.
  if (!recorded_.frames.is_empty() && recorded_.frames.end() >= instant.state.time) return;
  recorded_.frames.add(record(system, instant));
  if (frame_interval_ > 0.0) next_frame_ = instant.state.time + frame_interval_;
}

RecordedFrame Recording::record(const System& system, const Instant& instant) {
  RecordedFrame frame;
  frame.time = instant.state.time;
  std::vector<double> rows;
  gather_points(shown_, instant.state.positions, &rows);
  frame.positions.assign(rows.begin(), rows.end());
  if (!held_.empty()) add_reactions(instant, &frame);
  const std::vector<double> unique = unique_multipliers(instant.multipliers, instant.self_stress),
                            tensions = find_tensions(shown_, unique), tie_tensions = find_tie_tensions(shown_, unique);
  frame.tensions.assign(tensions.begin(), tensions.end());
  frame.tie_tensions.assign(tie_tensions.begin(), tie_tensions.end());
  for (const Observed& each : instant.observables)
    if (is_recorded(each)) frame.observed.insert(frame.observed.end(), each.values.begin(), each.values.end());
  std::vector<Guide> guides = place_guides(system, t_start_, frame.time);
  for (Guide& guide : guides) frame.guides.push_back(guide.numbers);
  if (guides_.empty()) guides_ = std::move(guides);
  return frame;
}

void Recording::add_reactions(const Instant& instant, RecordedFrame* frame) {
  const std::vector<double> positions(frame->positions.begin(), frame->positions.end());
  const std::vector<double> rows = find_guide_forces(shown_, positions, find_tensions(shown_, instant.multipliers),
                                                     instant.reactions, instant.support_forces);
  for (const std::int32_t k : held_) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      frame->normal_reactions.push_back(static_cast<float>(rows[3 * k + axis]));
      if (!instant.friction.empty())
        frame->tangent_reactions.push_back(
            static_cast<float>(instant.friction[3 * static_cast<std::size_t>(shown_.points[k]) + axis]));
    }
  }
}

std::vector<double> Recording::tensions() const {
  std::vector<double> all;
  for (const RecordedFrame& frame : frames()) all.insert(all.end(), frame.tensions.begin(), frame.tensions.end());
  return all;
}

bool Recording::fits(const RecordedFrame& frame) const {
  const std::size_t held = 3 * held_.size();
  return frame.positions.size() == 3 * shown_.num_points && frame.tensions.size() == shown_.rods.size() &&
         frame.tie_tensions.size() == shown_.ties.size() && frame.normal_reactions.size() == held &&
         (frame.tangent_reactions.empty() || frame.tangent_reactions.size() == held) &&
         std::ranges::equal(frame.guides, guides_, {}, &std::vector<double>::size,
                            [](const Guide& guide) { return guide.numbers.size(); });
}

bool Recording::go_on(Recorded before, const Simulation& simulation) {
  const MotionReport& report = simulation.report();
  events_ = report.events;
  friction_solves_ = report.friction.solves;
  friction_iterations_ = report.friction.iterations_mean * static_cast<double>(report.friction.solves);
  const double time = simulation.time();
  before.frames.cut(time);
  before.steps.cut(time);
  std::erase_if(before.switches, [&](const RecordedChange& each) { return each.time > time; });
  recorded_.events_before = events_;
  if (before.frames.is_empty()) return false;
  const std::vector<RecordedFrame> frames = before.frames.items();
  guides_ = place_guides(simulation.system(), t_start_, frames.front().time);
  if (!std::ranges::all_of(frames, [&](const RecordedFrame& frame) { return fits(frame); }) ||
      !recorded_.frames.take(std::move(before.frames)) || !recorded_.steps.take(std::move(before.steps))) {
    guides_.clear();
    return false;
  }
  recorded_.switches = std::move(before.switches);
  recorded_.events_before = before.events_before;
  if (frame_interval_ > 0.0) next_frame_ = recorded_.frames.end() + frame_interval_;
  return true;
}

void Recording::take_step(const MotionReport& report) {
  const FrictionSummary& friction = report.friction;
  const double iterations = friction.iterations_mean * static_cast<double>(friction.solves);
  recorded_.steps.add({.time = report.time,
                       .step = report.last_step,
                       .energy = report.energy.now,
                       .kinetic = report.energy.kinetic,
                       .potential = report.energy.potential,
                       .drift = report.energy.drift_relative(),
                       .position_violation = report.last_violation.position,
                       .velocity_violation = report.last_violation.velocity,
                       .acceleration_violation = report.last_violation.acceleration,
                       .reciprocal_condition = report.last_reciprocal_condition,
                       .friction_iterations = friction.solves > friction_solves_
                                                  ? (iterations - friction_iterations_) /
                                                        static_cast<double>(friction.solves - friction_solves_)
                                                  : 0.0});
  friction_solves_ = friction.solves;
  friction_iterations_ = iterations;
  if (report.events > events_ && recorded_.switches.size() < most_switches)
    recorded_.switches.push_back(
        {report.last_event, report.last_change.empty() ? "a contact sticks or slips" : report.last_change});
  events_ = report.events;
}

using namespace detail;

namespace {

constexpr std::string_view first_line_of_recording = "tanor recording 6\n";

/// Accepts any number, because a page draws what there is.
struct CheckNothing {
  template <class Value>
  void operator()(const Value&) const {}
};

/// Writes or reads everything between the first line and the last.
template <class Archive, class Text, class Number, class Recorded>
void exchange(Archive& archive, Text& fingerprint, Number& time, Recorded& recorded) {
  archive(fingerprint, time, recorded.frames, recorded.steps, recorded.switches, recorded.events_before);
}

}  // namespace

void write_recording(const std::filesystem::path& directory, const std::string& fingerprint, double time,
                     const Recording& recording) {
  std::string bytes;
  ByteWriter writer(
      [&](std::span<const std::byte> part) { bytes.append(reinterpret_cast<const char*>(part.data()), part.size()); });
  exchange(writer, fingerprint, time, recording.recorded());
  write_sealed(directory / recording_name, Wait::No, first_line_of_recording, {bytes, "\n"});
}

bool read_recording(const std::filesystem::path& directory, const std::string& fingerprint,
                    const Simulation& simulation, Recording* recording) {
  const std::filesystem::path path = directory / recording_name;
  if (!std::filesystem::exists(path)) return recording->go_on({}, simulation);
  const std::string text = scene::read_text(path);
  std::string_view content;
  if (open_sealed(text, first_line_of_recording, &content) != Seal::Sound) return recording->go_on({}, simulation);
  Recorded before;
  std::string theirs;
  double time = 0.0;
  ByteReader reader(std::as_bytes(std::span(content)), CheckNothing());
  try {
    exchange(reader, theirs, time, before);
  } catch (const EndsTooEarly&) {
    before = Recorded();
  }
  const bool is_ours = reader.num_left() == 1 && time >= simulation.time() && theirs == fingerprint;
  return recording->go_on(is_ours ? std::move(before) : Recorded(), simulation);
}

}  // namespace tanor::report
