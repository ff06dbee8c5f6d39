#include "report/checkpoint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "report/json_writer.hpp"
#include "report/npy.hpp"
#include "scene/npy.hpp"
#include "scene/text_file.hpp"

namespace tanor::report {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int format = 7;

fs::path path_in(const fs::path& directory) {
  return directory / "checkpoint";
}

/// visit(name, number) for every number of the head, to write them and to read them back.
template <class Checkpoint, class Visit>
void for_each_number(Checkpoint& checkpoint, const Visit& visit) {
  auto& snapshot = checkpoint.snapshot;
  auto& report = snapshot.report;
  visit("frames", checkpoint.trajectory.frames);
  visit("xyz_bytes", checkpoint.trajectory.xyz_bytes);
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
  visit("work_of_supports", report.energy.work_of_supports);
  visit("work_of_forces", report.energy.work_of_forces);
  visit("work_of_friction", report.energy.work_of_friction);
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

void read_number(const json& head, const char* name, double& number) {
  const json& value = head.at(name);
  number = value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>();
}

template <std::integral Integer>
void read_number(const json& head, const char* name, Integer& number) {
  number = head.at(name).get<Integer>();
}

void write_lists(JsonWriter* head, const MotionReport& report) {
  head->key("rank_changes").begin_array();
  for (const RankChange& change : report.rank_changes.first) {
    head->begin_array().value(change.time).value(change.rank).end_array();
  }
  head->end_array();
  head->key("singular_passages").begin_array();
  for (const SingularPassage& passage : report.singular_passages.first) {
    head->begin_array().value(passage.time).value(passage.reciprocal_condition).end_array();
  }
  head->end_array();
}

void read_lists(const json& head, MotionReport* report) {
  for (const json& change : head.at("rank_changes")) {
    report->rank_changes.first.push_back({change.at(0).get<double>(), change.at(1).get<std::size_t>()});
  }
  for (const json& passage : head.at("singular_passages")) {
    report->singular_passages.first.push_back({passage.at(0).get<double>(), passage.at(1).get<double>()});
  }
}

/// Choices are kept as their numbers.
template <class Choice>
requires std::is_enum_v<Choice>
void read_number(const json& head, const char* name, Choice& choice) {
  choice = static_cast<Choice>(head.at(name).get<int>());
}

template <class Number>
auto as_number(const Number& number) {
  if constexpr (std::is_enum_v<Number>)
    return static_cast<int>(number);
  else
    return number;
}

/// Plain numbers of any count, in the order in which they are written.
auto memories_of(auto& snapshot) {
  return std::array{&snapshot.solver_memory, &snapshot.singular_memory, &snapshot.state_before};
}

std::vector<double> read_points(const std::string& name, std::string_view* bytes, std::size_t num_points) {
  scene::NpyArray array = scene::read_npy(name, bytes);
  if (array.numbers.size() != 3 * num_points) throw InputError(name, "holds another number of points than the scene");
  return std::move(array.numbers);
}

/// FNV-1a, 64 bits, of bytes that come in pieces.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) value_ = (value_ ^ static_cast<unsigned char>(c)) * 0x100000001b3u;
  }
  void add(const std::vector<double>& numbers) {
    add({reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(double)});
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325u;
};

}  // namespace

std::string make_fingerprint(std::span<const fs::path> files, const System& system) {
  Hash hash;
  for (const fs::path& file : files) hash.add(scene::read_text(file));
  hash.add(system.positions);
  hash.add(system.velocities);
  hash.add(system.masses);
  return fmt::format("{:016x}", hash.value());
}

void write_checkpoint(const fs::path& directory, const Checkpoint& checkpoint) {
  replace_file(path_in(directory), [&](OutputFile* file) {
    JsonWriter head(file);
    head.begin_object();
    head.key("tanor_checkpoint").value(format);
    head.key("scene").value(checkpoint.scene);
    head.key("method").value(method_name(checkpoint.snapshot.report.method));
    for_each_number(checkpoint, [&](const char* name, const auto& number) { head.key(name).value(as_number(number)); });
    head.key("discrete_state").begin_array();
    for (const int number : checkpoint.snapshot.discrete_state) head.value(number);
    head.end_array();
    head.key("event_slopes").numbers(checkpoint.snapshot.event_slopes);
    head.key("doubt").value(checkpoint.snapshot.report.doubt);
    head.key("friction_uniqueness_reason").value(checkpoint.snapshot.report.friction.uniqueness_reason);
    write_lists(&head, checkpoint.snapshot.report);
    head.end_object();
    head.finish();
    write_npy(file, checkpoint.snapshot.positions, 3);
    write_npy(file, checkpoint.snapshot.velocities, 3);
    for (const std::vector<double>* memory : memories_of(checkpoint.snapshot)) write_npy(file, *memory, 1);
  });
}

std::optional<Checkpoint> read_checkpoint(const fs::path& directory, const std::string& fingerprint,
                                          std::size_t num_points) {
  const std::string name = path_in(directory).string();
  if (!fs::exists(name)) return std::nullopt;
  const std::string content = scene::read_text(name);
  const std::size_t begin_of_arrays = std::min(content.find("\x93NUMPY"), content.size());
  std::string_view arrays = std::string_view(content).substr(begin_of_arrays);

  Checkpoint checkpoint;
  try {
    const json head = json::parse(std::string_view(content).substr(0, begin_of_arrays));
    if (head.at("tanor_checkpoint") != format) throw InputError(name, "is of another version of tanor");
    checkpoint.scene = head.at("scene").get<std::string>();
    checkpoint.snapshot.report.method = method_from_name(head.at("method").get<std::string>());
    for_each_number(checkpoint, [&](const char* key, auto& number) { read_number(head, key, number); });
    checkpoint.snapshot.discrete_state = head.at("discrete_state").get<std::vector<int>>();
    checkpoint.snapshot.event_slopes = head.at("event_slopes").get<std::vector<double>>();
    checkpoint.snapshot.report.doubt = head.at("doubt").get<std::string>();
    checkpoint.snapshot.report.friction.uniqueness_reason = head.at("friction_uniqueness_reason").get<std::string>();
    read_lists(head, &checkpoint.snapshot.report);
  } catch (const json::exception&) {
    throw InputError(name, "is damaged; run without --resume");
  }
  if (checkpoint.scene != fingerprint) {
    throw InputError(name, "belongs to another scene, or one of its files was changed; run without --resume");
  }
  checkpoint.snapshot.positions = read_points(name, &arrays, num_points);
  checkpoint.snapshot.velocities = read_points(name, &arrays, num_points);
  for (std::vector<double>* memory : memories_of(checkpoint.snapshot)) *memory = scene::read_npy(name, &arrays).numbers;
  return checkpoint;
}

void remove_checkpoint(const fs::path& directory) {
  remove_file(path_in(directory));
}

}  // namespace tanor::report
