#include "report/summary.hpp"

#include <string>

#include <tanor/enum_names.hpp>
#include <tanor/version.hpp>

#include "report/field_json.hpp"
#include "report/json_text.hpp"
#include "report/page.hpp"
#include "report/shared_parts.hpp"
#include "report/words.hpp"

namespace tanor::report {

namespace {

constexpr const char* arrays_prefix = "final_";

void add_sizes(const RunEnd& end, JsonObjectFile* json) {
  using P = PlanSummary;
  json->add_members(json_of_members<&P::points, &P::supports, &P::equations>(end.plan));
  json->add_members(describe_rank(end.rank));
  json->add("islands", end.plan.islands);
}

/// Returns the rank at the start, and the times at which it changed, `count` in all.
Json describe_rank_changes(const RankChanges& changes) {
  const auto describe = [](const RankChange& change) { return Json{{"t", change.time}, {"rank", change.rank}}; };
  return {{"start", changes.start}, {"count", changes.count}, {"first", list_of(changes.first, describe)}};
}

/// Returns the times of singular configurations, at which constraints depend on each other, `count` in all.
Json describe_singular_passages(const SingularPassages& passages) {
  const auto describe = [](const SingularPassage& passage) {
    return Json{{"t", passage.time}, {"reciprocal_condition", passage.reciprocal_condition}};
  };
  return {{"count", passages.count}, {"first", list_of(passages.first, describe)}};
}

/// Returns the time at which the motion came nearest to a singular configuration.
Json describe_nearest_to_singular(const RunFacts& facts, const MotionReport& report) {
  return {{"t", if_started(facts, report.nearest_to_singular.time)},
          {"reciprocal_condition", if_started(facts, report.nearest_to_singular.reciprocal_condition)}};
}

void add_work(const MotionReport& report, JsonObjectFile* json) {
  using M = MotionReport;
  json->add_members(json_of_members<&M::steps, &M::rejected, &M::events>(report));
  json->add_members(json_of_members<&Counters::factorizations, &Counters::solves>(report.counters));
}

Json describe_times(const RunFacts& facts, const PhaseTimes& times, bool has_friction) {
  using T = PhaseTimes;
  Json json{{"total", facts.wall.total}, {"setup", facts.wall.setup}};
  json.update(json_of_members<&T::evaluate, &T::assemble, &T::factor, &T::solve, &T::friction>(times));
  json["output"] = facts.wall.output;
  return known_if(has_friction, std::move(json), "friction");
}

void add_final(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end, JsonObjectFile* json) {
  const ArrayWriter arrays(json, directory / arrays_prefix, end.plan.points);
  const bool is_known = facts.has_started && end.arrays;
  const auto find = [&](std::span<const double> EndArrays::*which) {
    return is_known ? Numbers((*end.arrays).*which) : std::nullopt;
  };
  json->begin_object("final");
  json->add("t", if_started(facts, end.time));
  arrays.write_points("positions", find(&EndArrays::positions));
  arrays.write_points("velocities", find(&EndArrays::velocities));
  arrays.write_points("accelerations", find(&EndArrays::accelerations));
  arrays.write_list("multipliers", has_multipliers(end.plan) ? find(&EndArrays::multipliers) : std::nullopt);
  arrays.write_points("reactions", find(&EndArrays::reactions));
  arrays.write_points("support_forces", find(&EndArrays::support_forces));
  json->end();
}

Json describe_violation(const RunFacts& facts, const MotionReport& report) {
  return {{"position_max", if_started(facts, report.violation.position)},
          {"velocity_max", if_started(facts, report.violation.velocity)},
          {"acceleration_max", if_started(facts, report.violation.acceleration)}};
}

Json describe_energy(const RunFacts& facts, const MotionReport& report, bool has_friction) {
  return {{"start", if_started(facts, report.energy.start)},
          {"end", if_started(facts, report.energy.now)},
          {"kinetic", if_started(facts, report.energy.kinetic)},
          {"potential", if_started(facts, report.energy.potential)},
          {"drift_relative", if_started(facts, report.energy.drift_relative())},
          {"work_of_friction", has_friction ? if_started(facts, report.energy.work_of_friction) : Json()},
          {"work_of_supports", if_started(facts, report.energy.work_of_supports)},
          {"work_of_forces", if_started(facts, report.energy.work_of_forces)},
          {"work_of_potentials", if_started(facts, report.energy.work_of_potentials)}};
}

}  // namespace

void write_summary(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end) {
  const MotionReport& report = end.report;
  const bool has_friction = end.contacts > 0;
  replace_file(directory / summary_name, [&](OutputFile* file) {
    JsonObjectFile json(file);
    json.add("scene", facts.scene);
    json.add("source", facts.source);
    json.add("tanor_version", TANOR_VERSION);
    json.add("units", end.units.name);
    json.add("observables", describe_observables(end.observables));
    json.add("passages", json_of(std::vector(end.passages.begin(), end.passages.end())));
    json.add("method", name_of(report.method));
    if (!report.method_reason.empty()) json.add("method_reason", report.method_reason);
    json.add("form", name_of(end.plan.form));
    json.add("threads", facts.threads);
    add_sizes(end, &json);
    json.add("t_end", facts.t_end);
    json.add("t_reached", end.time);
    json.add("stopped_by", json_or_null(facts.stopped_by));
    json.add("rank_changes", describe_rank_changes(report.rank_changes));
    json.add("singular_passages", describe_singular_passages(report.singular_passages));
    json.add("nearest_to_singular", describe_nearest_to_singular(facts, report));
    for (const char* key : {"accuracy_warning", "doubt"})  // the old name stays for one version
      json.add(key, json_or_null(report.accuracy_warning));
    add_work(report, &json);
    json.add("start_correction", if_started(facts, report.start.relative));
    json.add("start", {{"position", if_started(facts, report.start.position_correction)},
                       {"velocity", if_started(facts, report.start.velocity_correction)}});
    json.add("wall_s", describe_times(facts, report.times, has_friction));
    add_final(directory, facts, end, &json);
    json.add("violation", describe_violation(facts, report));
    json.add("energy", describe_energy(facts, report, has_friction));
    json.add("certificate", describe_certificate(facts.certificate));
    json.add("certificates", facts.certificates);
    json.add("friction", describe_friction_summary(end.contacts, report.friction));
    json.add("left_out", list_left_out(facts.left_out, end.plan.left_out));
    if (facts.tensions) json.add(tension_colours_key, {facts.tensions->least, facts.tensions->most});
    json.finish();
  });
}

void write_summary(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation) {
  write_summary(directory, facts,
                {count_contacts(simulation.system()), simulation.plan(), simulation.report(),
                 facts.has_started ? std::optional(simulation.rank()) : std::nullopt, simulation.time(),
                 EndArrays{simulation.positions(), simulation.velocities(), simulation.accelerations(),
                           simulation.multipliers(), simulation.reactions(), simulation.support_forces()},
                 simulation.observe(false), simulation.passages(), simulation.system().units});
}

std::vector<std::filesystem::path> list_summary(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files{directory / summary_name};
  for (const char* key :
       {"positions", "velocities", "accelerations", "multipliers", "reactions", "support_forces", "lowest_shape"})
    files.push_back(directory / (std::string(arrays_prefix) + key + ".npy"));
  return files;
}

}  // namespace tanor::report
