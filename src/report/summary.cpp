#include "report/summary.hpp"

#include <string>

#include <tanor/enum_names.hpp>
#include <tanor/version.hpp>

#include "report/array_writer.hpp"
#include "report/friction_parts.hpp"
#include "report/json_writer.hpp"
#include "report/shared_parts.hpp"

namespace tanor::report {

namespace {

constexpr const char* summary_name = "summary.json";
constexpr const char* arrays_prefix = "final_";

void write_sizes(JsonWriter* json, const RunFacts& facts, Simulation& simulation) {
  const PlanSummary& plan = simulation.plan();
  json->key("points").value(simulation.system().num_points());
  json->key("supports").value(plan.supports);
  json->key("equations").value(plan.equations);
  write_rank(json, facts.has_started ? std::optional(simulation.rank()) : std::nullopt);
  json->key("islands").value(plan.islands);
}

/// The rank at the start, and when it became another one, `count` times.
void write_rank_changes(JsonWriter* json, const RankChanges& changes) {
  json->key("rank_changes").begin_object();
  json->key("start").value(changes.start);
  json->key("count").value(changes.count);
  json->key("first").begin_array();
  for (const RankChange& change : changes.first) {
    json->begin_object();
    json->key("t").value(change.time);
    json->key("rank").value(change.rank);
    json->end_object();
  }
  json->end_array();
  json->end_object();
}

/// When the motion went through places at which constraints depend on each other, `count` times.
void write_singular_passages(JsonWriter* json, const SingularPassages& passages) {
  json->key("singular_passages").begin_object();
  json->key("count").value(passages.count);
  json->key("first").begin_array();
  for (const SingularPassage& passage : passages.first) {
    json->begin_object();
    json->key("t").value(passage.time);
    json->key("reciprocal_condition").value(passage.reciprocal_condition);
    json->end_object();
  }
  json->end_array();
  json->end_object();
}

/// Where the motion came nearest to a place at which constraints depend on each other.
void write_nearest_to_singular(JsonWriter* json, const RunFacts& facts, const MotionReport& report) {
  const auto found = [&](double number) { return facts.has_started ? std::optional(number) : std::nullopt; };
  json->key("nearest_to_singular").begin_object();
  json->key("t").value(found(report.reciprocal_condition_time));
  json->key("reciprocal_condition").value(found(report.reciprocal_condition));
  json->end_object();
}

void write_work(JsonWriter* json, const MotionReport& report) {
  json->key("steps").value(report.steps);
  json->key("rejected").value(report.rejected);
  json->key("events").value(report.events);
  json->key("factorizations").value(report.counters.factorizations);
  json->key("solves").value(report.counters.solves);
}

void write_start(JsonWriter* json, const RunFacts& facts, const StartReport& start) {
  const auto found = [&](double number) { return facts.has_started ? std::optional(number) : std::nullopt; };
  json->key("start_correction").value(found(start.relative));
  json->key("start").begin_object();
  json->key("position").value(found(start.position_correction));
  json->key("velocity").value(found(start.velocity_correction));
  json->end_object();
}

void write_times(JsonWriter* json, const RunFacts& facts, const PhaseTimes& times, bool has_friction) {
  json->key("wall_s").begin_object();
  json->key("total").value(facts.wall.total);
  json->key("setup").value(facts.wall.setup);
  json->key("evaluate").value(times.evaluate);
  json->key("assemble").value(times.assemble);
  json->key("factor").value(times.factor);
  json->key("solve").value(times.solve);
  json->key("friction").value(has_friction ? std::optional(times.friction) : std::nullopt);
  json->key("output").value(facts.wall.output);
  json->end_object();
}

void write_final(JsonWriter* json, const std::filesystem::path& directory, const RunFacts& facts,
                 const Simulation& simulation) {
  const auto found = [&](std::span<const double> numbers) {
    return facts.has_started ? Numbers(numbers) : std::nullopt;
  };
  ArrayWriter arrays(json, directory / arrays_prefix, simulation.system().num_points());
  json->key("final").begin_object();
  json->key("t").value(facts.has_started ? std::optional(simulation.time()) : std::nullopt);
  arrays.write_points("positions", found(simulation.positions()));
  arrays.write_points("velocities", found(simulation.velocities()));
  arrays.write_points("accelerations", found(simulation.accelerations()));
  arrays.write_list("multipliers", has_multipliers(simulation.plan()) ? found(simulation.multipliers()) : std::nullopt);
  arrays.write_points("reactions", found(simulation.reactions()));
  arrays.write_points("support_forces", found(simulation.support_forces()));
  json->end_object();
}

void write_quality(JsonWriter* json, const RunFacts& facts, const MotionReport& report, bool has_friction) {
  const auto found = [&](double number) { return facts.has_started ? std::optional(number) : std::nullopt; };
  json->key("violation").begin_object();
  json->key("position_max").value(found(report.position_violation));
  json->key("velocity_max").value(found(report.velocity_violation));
  json->key("acceleration_max").value(found(report.acceleration_violation));
  json->end_object();

  json->key("energy").begin_object();
  json->key("start").value(found(report.energy.start));
  json->key("end").value(found(report.energy.now));
  json->key("drift_relative").value(found(report.energy.drift_relative()));
  json->key("work_of_friction").value(has_friction ? found(report.energy.work_of_friction) : std::nullopt);
  json->key("work_of_supports").value(found(report.energy.work_of_supports));
  json->key("work_of_forces").value(found(report.energy.work_of_forces));
  json->end_object();

  write_certificate(json, facts.certificate);
}

}  // namespace

void write_summary(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation) {
  const MotionReport& report = simulation.report();
  const bool has_friction = !simulation.system().friction.empty();
  replace_file(directory / summary_name, [&](OutputFile* file) {
    JsonWriter json(file);
    json.begin_object();
    json.key("scene").value(facts.scene);
    json.key("source").value(facts.source);
    json.key("tanor_version").value(TANOR_VERSION);
    json.key("method").value(name_of(report.method));
    if (!report.method_reason.empty()) json.key("method_reason").value(report.method_reason);
    json.key("form").value(name_of(simulation.plan().form));
    json.key("threads").value(facts.threads);
    write_sizes(&json, facts, simulation);
    json.key("t_end").value(facts.t_end);
    json.key("t_reached").value(simulation.time());
    write_rank_changes(&json, report.rank_changes);
    write_singular_passages(&json, report.singular_passages);
    write_nearest_to_singular(&json, facts, report);
    for (const char* key : {"accuracy_warning", "doubt"}) {  // the old name stays for one version
      json.key(key);
      if (report.accuracy_warning.empty())
        json.value(std::optional<double>());
      else
        json.value(report.accuracy_warning);
    }
    write_work(&json, report);
    write_start(&json, facts, report.start);
    write_times(&json, facts, report.times, has_friction);
    write_final(&json, directory, facts, simulation);
    write_quality(&json, facts, report, has_friction);
    write_friction_summary(&json, simulation.system(), report.friction);
    write_left_out(&json, simulation.plan().left_out);
    json.end_object();
    json.finish();
  });
}

void remove_summary(const std::filesystem::path& directory) {
  remove_file(directory / summary_name);
  for (const char* key : {"positions", "velocities", "accelerations", "multipliers", "reactions", "support_forces"}) {
    remove_file(directory / (std::string(arrays_prefix) + key + ".npy"));
  }
}

}  // namespace tanor::report
