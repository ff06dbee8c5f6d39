#include "report/shared_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include <tanor/enum_names.hpp>

#include "base/text.hpp"
#include "report/field_json.hpp"
#include "report/words.hpp"

namespace tanor::report {

bool has_multipliers(const PlanSummary& plan) {
  return plan.form == Form::Normal || plan.equations > 0;
}

Json if_started(const RunFacts& facts, double number) {
  return facts.has_started ? Json(number) : Json();
}

Json describe_certificate(const std::optional<Certificate>& certificate) {
  const Json json = json_of(certificate.value_or(Certificate()));
  return known_if(certificate.has_value(), json, "passed", "certified_to", "verdict");
}

Json describe_times(const RunFacts& facts, const PhaseTimes& times, bool has_friction) {
  Json json{{"total", facts.wall.total}, {"setup", facts.wall.setup}};
  json.update(json_of(times));
  json["output"] = facts.wall.output;
  return known_if(has_friction, std::move(json), "friction");
}

Json describe_rank(const std::optional<RankReport>& rank) {
  Json redundant;
  if (rank) {
    redundant = Json::array();
    for (const RowDependence& dependence : rank->dependences) redundant.push_back(dependence.what);
  }
  return {{"rank", rank && rank->is_known ? Json(rank->rank) : Json()},
          {"degrees_of_freedom", rank ? Json(rank->degrees_of_freedom) : Json()},
          {"redundant", redundant}};
}

std::string describe_redundancy(const RankReport& rank) {
  constexpr std::size_t most_lines = 3;
  const std::size_t count = rank.dependences.size();
  if (count == 0) return {};
  std::string text =
      fmt::format("{} of {} equations {} redundant: ", count, rank.rank + count, count == 1 ? "is" : "are");
  for (std::size_t k = 0; k < std::min(count, most_lines); ++k) {
    text += (k > 0 ? "; " : "") + rank.dependences[k].what;
  }
  return text + (count > most_lines ? "; …" : "");
}

Json list_groups(const System& system) {
  Json groups = Json::array();
  for_each_group(system, [&](const std::string& name, std::size_t g, std::size_t first, std::size_t members) {
    groups.push_back({{"name", name},
                      {"kind", kind_name(system.constraints[g])},
                      {"first", first},
                      {"members", members},
                      {"rows", detail::shape_of(system.constraints[g]).rows_per_member}});
  });
  return groups;
}

using namespace detail;

namespace {

/// Returns "coulomb, exact", "coulomb, regularised, full reaction" or "viscous".
std::string name_law(const Friction& friction) {
  std::string law(kind_name(friction));
  std::visit(
      [&]<class Law>(const Law& given) {
        if constexpr (requires { KindOf<Law>::variant(given); }) law += ", " + KindOf<Law>::variant(given);
      },
      friction);
  return law;
}

std::string name_contacts(std::size_t count) {
  return count_in_words(count, "contact");
}

std::string describe_uniqueness(Uniqueness uniqueness, const std::string& reason) {
  return std::string(name_of(uniqueness)) + (reason.empty() ? "" : " (" + reason + ")");
}

}  // namespace

std::size_t count_contacts(const System& system) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < system.friction.size(); ++k) count += num_contacts(system, k);
  return count;
}

Json describe_friction_report(const std::optional<FrictionReport>& report) {
  const FrictionReport found = report.value_or(FrictionReport());
  Json json = json_of(found);
  json = known_if(report.has_value(), std::move(json), "contacts", "sticking");
  json = known_if(found.contacts > 0, std::move(json), "sticking_is_indeterminate");
  return known_if(found.method_used != FrictionMethod::Auto, std::move(json), "iterations", "contraction", "residual");
}

Json describe_friction_summary(std::size_t contacts, const FrictionSummary& summary) {
  Json json{{"contacts", contacts}};
  json.update(json_of(summary));
  return known_if(summary.solves > 0, std::move(json), "iterations_mean", "iterations_max", "contraction_max",
                  "residual_max");
}

std::string describe_friction(const System& system) {
  std::string list;
  for (std::size_t k = 0; k < system.friction.size(); ++k) {
    list += fmt::format("{}{} ({}, {})", k > 0 ? ", " : "", friction_name(system, k), name_law(system.friction[k]),
                        name_contacts(num_contacts(system, k)));
  }
  return list.empty() ? "none" : list;
}

std::string describe_friction(const FrictionReport& report) {
  std::string text = fmt::format("{}, {} stick", name_contacts(report.contacts), report.sticking);
  if (report.method_used != FrictionMethod::Auto)
    text += fmt::format(", {} ({})", count_in_words(report.iterations, "iteration"), name_of(report.method_used));
  return text + fmt::format(", uniqueness {}", describe_uniqueness(report.uniqueness, report.uniqueness_reason));
}

std::string describe_friction(const FrictionSummary& summary) {
  if (summary.solves == 0) return "no iterations";
  return fmt::format("{} an instant, {} at most ({}), contraction {}, uniqueness {}",
                     count_in_words(fmt::format("{:.3g}", summary.iterations_mean), "iteration"),
                     summary.iterations_max, name_of(summary.method_used), in_words(summary.contraction_max, "{:.2g}"),
                     describe_uniqueness(summary.uniqueness, summary.uniqueness_reason));
}

std::string describe_several(const FrictionSummary& summary, const Units& units) {
  if (summary.several == 0) return "";
  return fmt::format(
      "friction: several accelerations obeyed the law at {}, at t = {} first; the motion goes on with those "
      "nearest to the step before",
      count_in_words(summary.several, "instant"), with_unit(text(summary.first_several), units.time));
}

}  // namespace tanor::report
