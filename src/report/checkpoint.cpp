#include "report/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "report/checksum.hpp"
#include "report/json_text.hpp"
#include "report/npy.hpp"
#include "report/words.hpp"
#include "scene/npy.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int format = 9;

fs::path path_in(const fs::path& directory) {
  return directory / "checkpoint";
}

/// Calls visit(name, number) for every number of the head. The same list serves to write them and to read them back.
template <class Checkpoint, class Visit>
void for_each_number(Checkpoint& checkpoint, const Visit& visit) {
  auto& snapshot = checkpoint.snapshot;
  auto& report = snapshot.report;
  visit("frames", checkpoint.trajectory.frames);
  visit("xyz_bytes", checkpoint.trajectory.xyz_bytes);
  visit("pvd_bytes", checkpoint.trajectory.pvd_bytes);
  visit("wall_total", checkpoint.wall.total);
  visit("wall_setup", checkpoint.wall.setup);
  visit("wall_output", checkpoint.wall.output);
  visit("time", snapshot.time);
  visit("next_step", snapshot.next_step);
  visit("last_error", snapshot.last_error);
  visit("advance_begin", snapshot.advance_begin);
  visit("advance_end", snapshot.advance_end);
  visit("steps", report.steps);
  visit("rejected", report.rejected);
  visit("last_step", report.last_step);
  visit("events", report.events);
  visit("last_event", report.last_event);
  visit("start_position", report.start.position_correction);
  visit("start_velocity", report.start.velocity_correction);
  visit("start_relative", report.start.relative);
  visit("position_violation", report.position_violation);
  visit("velocity_violation", report.velocity_violation);
  visit("acceleration_violation", report.acceleration_violation);
  visit("reciprocal_condition", report.reciprocal_condition);
  visit("reciprocal_condition_time", report.reciprocal_condition_time);
  visit("rank_start", report.rank_changes.start);
  visit("rank_now", report.rank_changes.now);
  visit("num_rank_changes", report.rank_changes.count);
  visit("num_singular_passages", report.singular_passages.count);
  visit("energy_start", report.energy.start);
  visit("energy_now", report.energy.now);
  visit("potential_at_start", report.energy.potential_at_start);
  visit("work_of_supports", report.energy.work_of_supports);
  visit("work_of_forces", report.energy.work_of_forces);
  visit("work_of_friction", report.energy.work_of_friction);
  visit("largest_drift", report.energy.largest_drift);
  visit("largest_drift_time", report.energy.largest_drift_time);
  visit("energy_scale", report.energy.scale);
  visit("evaluations", report.counters.evaluations);
  visit("factorizations", report.counters.factorizations);
  visit("solves", report.counters.solves);
  visit("iterations", report.counters.iterations);
  visit("rank_decisions", report.counters.rank_decisions);
  visit("evaluate_s", report.times.evaluate);
  visit("assemble_s", report.times.assemble);
  visit("factor_s", report.times.factor);
  visit("solve_s", report.times.solve);
  visit("friction_s", report.times.friction);
  visit("instants_of_friction", report.counters.friction_solves);
  visit("friction_iterations", report.counters.friction_iterations);
  visit("friction_solves", report.friction.solves);
  visit("friction_iterations_mean", report.friction.iterations_mean);
  visit("friction_iterations_max", report.friction.iterations_max);
  visit("friction_contraction_max", report.friction.contraction_max);
  visit("friction_error_bound", report.friction.error_bound);
  visit("friction_residual_max", report.friction.residual_max);
  visit("friction_several", report.friction.several);
  visit("friction_first_several", report.friction.first_several);
  visit("friction_uniqueness", report.friction.uniqueness);
  visit("friction_method_used", report.friction.method_used);
}

void read_number(const json& value, const char* name, double& number) {
  if (!value.is_null() && !value.is_number()) {
    throw InputError("", fmt::format("/{} is {}, not a number", name, value.dump()));
  }
  number = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

/// Refuses -1 and 1.5, which a JSON reader would convert to a count.
template <std::integral Integer>
void read_number(const json& value, const char* name, Integer& number) {
  const bool is_count = value.is_number_unsigned() &&
                        value.get<std::uint64_t>() <= static_cast<std::uint64_t>(std::numeric_limits<Integer>::max());
  if (!is_count) throw InputError("", fmt::format("/{} is {}, not a count", name, value.dump()));
  number = value.get<Integer>();
}

Json list_rank_changes(const MotionReport& report) {
  Json list = Json::array();
  for (const RankChange& change : report.rank_changes.first) list.push_back({change.time, change.rank});
  return list;
}

Json list_singular_passages(const MotionReport& report) {
  Json list = Json::array();
  for (const SingularPassage& passage : report.singular_passages.first)
    list.push_back({passage.time, passage.reciprocal_condition});
  return list;
}

void read_lists(const json& head, MotionReport* report) {
  for (const json& change : head.at("rank_changes")) {
    RankChange& read = report->rank_changes.first.emplace_back();
    read_number(change.at(0), "rank_changes", read.time);
    read_number(change.at(1), "rank_changes", read.rank);
  }
  for (const json& passage : head.at("singular_passages")) {
    SingularPassage& read = report->singular_passages.first.emplace_back();
    read_number(passage.at(0), "singular_passages", read.time);
    read_number(passage.at(1), "singular_passages", read.reciprocal_condition);
  }
}

/// The last of the choices that are kept.
constexpr Uniqueness last_choice(Uniqueness) {
  return Uniqueness::None;
}
constexpr FrictionMethod last_choice(FrictionMethod) {
  return FrictionMethod::Enumeration;
}

/// Choices are stored as their numbers.
template <class Choice>
requires std::is_enum_v<Choice>
void read_number(const json& value, const char* name, Choice& choice) {
  unsigned number = 0;
  read_number(value, name, number);
  if (number > static_cast<unsigned>(last_choice(choice))) {
    throw InputError("", fmt::format("/{} is {}, at most {}", name, number, static_cast<int>(last_choice(choice))));
  }
  choice = static_cast<Choice>(number);
}

/// Refuses numbers that no run can have. Simulation::restore checks the rest of the snapshot.
void require_sound(const Checkpoint& checkpoint) {
  const Snapshot& snapshot = checkpoint.snapshot;
  const MotionReport& report = snapshot.report;
  const std::pair<const char*, double> sizes[] = {
      {"wall_total", checkpoint.wall.total},   {"wall_setup", checkpoint.wall.setup},
      {"wall_output", checkpoint.wall.output}, {"next_step", snapshot.next_step},
      {"last_error", snapshot.last_error},     {"evaluate_s", report.times.evaluate},
      {"assemble_s", report.times.assemble},   {"factor_s", report.times.factor},
      {"solve_s", report.times.solve},         {"friction_s", report.times.friction}};
  for (const auto& [name, size] : sizes) {
    if (!(size >= 0.0)) throw InputError("", fmt::format("/{} is {}, not 0 or more", name, in_words(size)));
  }
  for (const auto& [name, time] : {std::pair{"time", snapshot.time},
                                   {"advance_begin", snapshot.advance_begin},
                                   {"advance_end", snapshot.advance_end},
                                   {"last_step", report.last_step}}) {
    if (!std::isfinite(time)) throw InputError("", fmt::format("/{} is {}, not a time", name, in_words(time)));
  }
  const TrajectoryMark& mark = checkpoint.trajectory;
  if (mark.frames == 0 || mark.frames > mark.xyz_bytes || mark.frames > mark.pvd_bytes) {
    throw InputError("", fmt::format("/frames is {}, of {} and {} bytes", mark.frames, mark.xyz_bytes, mark.pvd_bytes));
  }
  if (report.rank_changes.count < report.rank_changes.first.size() ||
      report.singular_passages.count < report.singular_passages.first.size()) {
    throw InputError("", "counts fewer changes than it lists");
  }
}

template <class Number>
auto as_number(const Number& number) {
  if constexpr (std::is_enum_v<Number>)
    return static_cast<int>(number);
  else
    return number;
}

/// The memories of a snapshot, each of any size, in the order in which they are written.
auto memories_of(auto& snapshot) {
  return std::array{&snapshot.memory,          &snapshot.drive_memory, &snapshot.singular_memory,
                    &snapshot.rounding_memory, &snapshot.stiff_memory, &snapshot.state_before};
}

std::vector<double> read_points(std::string_view* bytes, std::size_t num_points) {
  scene::NpyArray array = scene::read_npy("", bytes);
  if (array.numbers.size() != 3 * num_points) throw InputError("", "holds another number of points than the scene");
  return std::move(array.numbers);
}

/// The file has a line with the format, the content, and a line with the checksum of everything before it.
constexpr std::string_view first_words = "tanor checkpoint ";
constexpr std::string_view last_words = "checksum ";

std::string first_line() {
  return fmt::format("{}{}\n", first_words, format);
}

std::string last_line(const Checksum& sum) {
  return fmt::format("{}{}\n", last_words, sum.text());
}

/// Returns the content of a checkpoint's text. Throws InputError where a byte of it is not what was written.
std::string_view open_content(std::string_view text) {
  if (!text.starts_with(first_line())) {
    const bool is_other = text.starts_with(first_words) || text.starts_with("{\n  \"tanor_checkpoint\"");
    throw InputError("",
                     is_other ? "is of another version of tanor; run without --resume" : "is no checkpoint of tanor");
  }
  const std::size_t end = text.rfind(last_words);
  Checksum sum;
  sum.add(text.substr(0, end));
  if (end == std::string_view::npos || text.substr(end) != last_line(sum)) {
    throw InputError("", "is damaged: its checksum is another one; run without --resume");
  }
  return text.substr(first_line().size(), end - first_line().size());
}

void write_content(OutputFile* file, const Checkpoint& checkpoint) {
  const MotionReport& report = checkpoint.snapshot.report;
  JsonObjectFile head(file);
  head.add("scene", checkpoint.scene);
  head.add("method", method_name(report.method));
  for_each_number(checkpoint, [&](const char* name, const auto& number) { head.add(name, as_number(number)); });
  head.add("discrete_state", checkpoint.snapshot.discrete_state);
  head.add("event_slopes", checkpoint.snapshot.event_slopes);
  head.add("accuracy_warning", report.accuracy_warning);
  head.add("friction_uniqueness_reason", report.friction.uniqueness_reason);
  head.add("rank_changes", list_rank_changes(report));
  head.add("singular_passages", list_singular_passages(report));
  head.finish();
  write_npy(file, checkpoint.snapshot.positions, 3);
  write_npy(file, checkpoint.snapshot.velocities, 3);
  for (const std::vector<double>* memory : memories_of(checkpoint.snapshot)) write_npy(file, *memory, 1);
}

Checkpoint read_content(std::string_view content, const std::string& fingerprint, std::size_t num_points) {
  const std::size_t begin_of_arrays = std::min(content.find("\x93NUMPY"), content.size());
  std::string_view arrays = content.substr(begin_of_arrays);
  Checkpoint checkpoint;
  Snapshot& snapshot = checkpoint.snapshot;
  try {
    const json head = json::parse(content.substr(0, begin_of_arrays));
    checkpoint.scene = head.at("scene").get<std::string>();
    snapshot.report.method = method_from_name(head.at("method").get<std::string>());
    for_each_number(checkpoint, [&](const char* key, auto& number) { read_number(head.at(key), key, number); });
    for (const json& mode : head.at("discrete_state")) {
      if (!mode.is_number_integer()) throw InputError("", fmt::format("/discrete_state holds {}", mode.dump()));
      snapshot.discrete_state.push_back(mode.get<int>());
    }
    snapshot.event_slopes = head.at("event_slopes").get<std::vector<double>>();
    snapshot.report.accuracy_warning = head.at("accuracy_warning").get<std::string>();
    snapshot.report.friction.uniqueness_reason = head.at("friction_uniqueness_reason").get<std::string>();
    read_lists(head, &snapshot.report);
  } catch (const json::exception& error) {
    throw InputError("", fmt::format("cannot be read: {}", error.what()));
  }
  if (checkpoint.scene != fingerprint) {
    throw InputError("", "belongs to another scene, or one of its files was changed; run without --resume");
  }
  require_sound(checkpoint);
  snapshot.positions = read_points(&arrays, num_points);
  snapshot.velocities = read_points(&arrays, num_points);
  for (std::vector<double>* memory : memories_of(snapshot)) *memory = scene::read_npy("", &arrays).numbers;
  if (!arrays.empty()) throw InputError("", "holds more than a checkpoint");
  return checkpoint;
}

}  // namespace

std::string make_fingerprint(std::span<const fs::path> files, const System& system) {
  Checksum sum;
  for (const fs::path& file : files) sum.add(scene::read_text(file));
  for (const auto* numbers : {&system.positions, &system.velocities, &system.masses}) sum.add(*numbers);
  return sum.text();
}

void write_checkpoint(const fs::path& directory, const Checkpoint& checkpoint, Wait wait) {
  replace_file(path_in(directory), wait, [&](OutputFile* file) {
    Checksum sum;
    file->sum_into(&sum);
    file->write(first_line());
    write_content(file, checkpoint);
    file->sum_into(nullptr);
    file->write(last_line(sum));
  });
}

std::optional<Checkpoint> read_checkpoint(const fs::path& directory, const std::string& fingerprint,
                                          std::size_t num_points) {
  const std::string name = path_in(directory).string();
  if (!fs::exists(name)) return std::nullopt;
  const std::string text = scene::read_text(name);
  try {
    return read_content(open_content(text), fingerprint, num_points);
  } catch (const InputError& error) {
    throw InputError(error.where().empty() ? name : fmt::format("{}: {}", name, error.where()), error.what());
  }
}

void remove_checkpoint(const fs::path& directory) {
  remove_file(path_in(directory));
}

}  // namespace tanor::report
