#include "report/summary.hpp"

#include <algorithm>
#include <string>

#include <tanor/enum_names.hpp>

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
  json->add("groups", end.groups);
}

void add_work(const MotionReport& report, JsonObjectFile* json) {
  using M = MotionReport;
  json->add_members(json_of_members<&M::steps, &M::rejected>(report));
  json->add("contact_changes", report.events);
  json->add_members(json_of_members<&Counters::factorizations, &Counters::solves>(report.counters));
}

void add_final(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end, JsonObjectFile* json) {
  const ArrayWriter arrays(json, end.units, directory / arrays_prefix, end.plan.points);
  const bool is_known = facts.has_started && end.arrays;
  const auto find = [&](std::span<const double> EndArrays::*which) {
    return is_known ? Numbers((*end.arrays).*which) : std::nullopt;
  };
  json->begin_object("final");
  json->add("t", if_started(facts, end.time));
  arrays.write_points("positions", Dimension::Length, find(&EndArrays::positions));
  arrays.write_points("velocities", Dimension::Velocity, find(&EndArrays::velocities));
  arrays.write_points("accelerations", Dimension::Acceleration, find(&EndArrays::accelerations));
  arrays.write_list("multipliers", has_multipliers(end.plan) ? find(&EndArrays::multipliers) : std::nullopt);
  const bool has_stress = is_known && !end.arrays->self_stress.empty();
  arrays.write_list("self_stress", has_stress ? Numbers(end.arrays->self_stress) : std::nullopt);
  arrays.write_points("reactions", Dimension::Forces, find(&EndArrays::reactions));
  arrays.write_points("support_forces", Dimension::Forces, find(&EndArrays::support_forces));
  json->end();
}

}  // namespace

RunFacts facts_of(const scene::Scene& scene, int threads, bool has_started) {
  RunFacts facts;
  facts.scene = scene.name;
  facts.source = scene.source;
  facts.left_out = scene.left_out;
  facts.threads = scene.solver.threads > 0 ? scene.solver.threads : threads;
  facts.t_start = scene.t_start;
  facts.t_end = scene.t_end;
  facts.has_started = has_started;
  facts.wants_certificate = scene.certificate.when != scene::CertificatePolicy::When::Off;
  return facts;
}

namespace {

/// Returns what happened to one-sided constraints, with the names of their members in place of equations.
Json describe_events(const std::vector<ContactEvent>& events, const Json& groups) {
  const auto name = [&](std::size_t equation) {
    for (const Json& group : groups) {
      const auto first = group.at("first").get<std::size_t>(), members = group.at("members").get<std::size_t>();
      const auto rows = group.at("rows").get<std::size_t>();
      if (equation >= first && equation < first + members * rows)
        return fmt::format("{}[{}]", group.at("name").get<std::string>(), (equation - first) / rows);
    }
    return std::to_string(equation);
  };
  Json list = Json::array();
  for (const ContactEvent& event : events) {
    Json json = json_of(event), rows = Json::array();
    for (const std::size_t equation : event.equations) rows.push_back(name(equation));
    json.erase("equations");
    json["rows"] = std::move(rows);
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace

void write_summary(const std::filesystem::path& directory, const RunFacts& facts, const RunEnd& end) {
  const MotionReport& report = end.report;
  const bool has_friction = end.contacts > 0;
  replace_file(directory / summary_name, [&](OutputFile* file) {
    JsonObjectFile json(file);
    json.add_members(describe_head(facts.scene, facts.source, end.units, end.observables));
    json.add("passages", json_of(std::vector(end.passages.begin(), end.passages.end())));
    json.add("method", name_of(report.method));
    if (!report.method_reason.empty()) json.add("method_reason", report.method_reason);
    json.add("form", name_of(end.plan.form));
    json.add("threads", facts.threads);
    add_sizes(end, &json);
    json.add("t_end", facts.t_end);
    json.add("t_reached", end.time);
    json.add("stopped_by", json_or_null(facts.stopped_by));
    if (!report.contact_events.empty()) {
      json.add("events", describe_events(report.contact_events, end.groups));
      json.add("restitution_capped",
               std::ranges::count(report.contact_events, true, &ContactEvent::restitution_capped));
    }
    json.add("rank_changes", json_of(report.rank_changes));
    json.add("singular_passages", json_of(report.singular_passages));
    json.add("nearest_to_singular", known_if(facts.has_started, json_of(report.nearest_to_singular)));
    for (const char* key : {"accuracy_warning", "doubt"})  // the old name stays for one version
      json.add(key, json_or_null(report.accuracy_warning));
    add_work(report, &json);
    json.add("start_correction", if_started(facts, report.start.relative));
    json.add("start", {{"position", if_started(facts, report.start.position_correction)},
                       {"velocity", if_started(facts, report.start.velocity_correction)}});
    json.add("wall_s", describe_times(facts, report.times, has_friction));
    add_final(directory, facts, end, &json);
    json.add("violation", known_if(facts.has_started, json_of(report.violation)));
    const Json energy = known_if(facts.has_started, json_of(report.energy));
    json.add("energy", known_if(has_friction, energy, "work_of_friction"));
    json.add("certificate", describe_certificate(facts.certificate));
    json.add("certificates", facts.certificates);
    json.add("friction", describe_friction_summary(end.contacts, report.friction));
    for (const auto& [name, each] : facts.arrays.items()) json.add_file(name, each);
    json.add("left_out", list_left_out(facts.left_out, end.plan.left_out));
    if (facts.tensions) json.add(tension_colours_key, {facts.tensions->least, facts.tensions->most});
    json.finish();
  });
}

void write_summary(const std::filesystem::path& directory, const RunFacts& facts, Simulation& simulation) {
  write_summary(
      directory, facts,
      {count_contacts(simulation.system()), simulation.plan(), simulation.report(),
       facts.has_started ? std::optional(simulation.rank()) : std::nullopt, simulation.time(),
       EndArrays{simulation.positions(), simulation.velocities(), simulation.accelerations(), simulation.multipliers(),
                 simulation.self_stress(), simulation.reactions(), simulation.support_forces()},
       simulation.observe(false), simulation.passages(), simulation.system().units, list_groups(simulation.system())});
}

std::vector<std::filesystem::path> list_summary(const std::filesystem::path& directory) {
  std::vector<std::filesystem::path> files{directory / summary_name};
  for (const char* key : {"positions", "velocities", "accelerations", "multipliers", "self_stress", "reactions",
                          "support_forces", "lowest_shape"})
    files.push_back(directory / (std::string(arrays_prefix) + key + ".npy"));
  return files;
}

}  // namespace tanor::report
