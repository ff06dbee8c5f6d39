#include "report/friction_parts.hpp"

#include <fmt/format.h>

#include <string_view>

#include <tanor/enum_names.hpp>

#include "report/words.hpp"

namespace tanor::report {

namespace {

std::size_t count_contacts(const System& system) {
  std::size_t count = 0;
  for (std::size_t k = 0; k < system.friction.size(); ++k) count += num_contacts(system, k);
  return count;
}

/// "coulomb, exact", "coulomb, regularised, full reaction", "viscous"
std::string name_law(const Friction& friction) {
  std::string law(kind_name(friction));
  if (const auto* coulomb = std::get_if<Coulomb>(&friction)) {
    law += coulomb->regularisation ? ", regularised" : ", exact";
    if (coulomb->reaction == Coulomb::Reaction::Full) law += ", full reaction";
  }
  return law;
}

std::string name_contacts(std::size_t count) {
  return fmt::format("{} contact{}", count, count == 1 ? "" : "s");
}

/// Null where no friction depends on reactions: nothing was iterated.
void write_method(JsonWriter* json, FrictionMethod method) {
  json->key("method_used");
  method == FrictionMethod::Auto ? json->null() : json->value(name_of(method));
}

void write_uniqueness(JsonWriter* json, Uniqueness uniqueness, const std::string& reason) {
  json->key("uniqueness");
  uniqueness == Uniqueness::NotAsked ? json->null() : json->value(name_of(uniqueness));
  json->key("uniqueness_reason");
  reason.empty() ? json->null() : json->value(reason);
}

std::string describe_uniqueness(Uniqueness uniqueness, const std::string& reason) {
  return std::string(name_of(uniqueness)) + (reason.empty() ? "" : " (" + reason + ")");
}

}  // namespace

void write_friction_report(JsonWriter* json, const std::optional<FrictionReport>& report) {
  const FrictionReport& found = report ? *report : FrictionReport();
  const bool is_iterated = report && found.method_used != FrictionMethod::Auto;
  const auto count = [&](std::size_t number) { report ? json->value(number) : json->null(); };
  const auto figure = [&](double number) { is_iterated ? json->value(number) : json->null(); };
  json->key("friction_report").begin_object();
  json->key("contacts");
  count(found.contacts);
  json->key("sticking");
  count(found.sticking);
  json->key("sticking_is_indeterminate");
  found.contacts > 0 ? json->value(found.sticking_is_indeterminate) : json->null();
  json->key("iterations");
  is_iterated ? json->value(found.iterations) : json->null();
  json->key("contraction");
  figure(found.contraction);
  json->key("residual");
  figure(found.residual);
  json->key("error_bound").value(found.error_bound);
  write_uniqueness(json, found.uniqueness, found.uniqueness_reason);
  write_method(json, found.method_used);
  json->end_object();
}

void write_friction_summary(JsonWriter* json, const System& system, const FrictionSummary& summary) {
  const bool is_iterated = summary.solves > 0;
  const auto figure = [&](double number) { is_iterated ? json->value(number) : json->null(); };
  json->key("friction").begin_object();
  json->key("contacts").value(count_contacts(system));
  json->key("solves").value(summary.solves);
  json->key("iterations_mean");
  figure(summary.iterations_mean);
  json->key("iterations_max");
  is_iterated ? json->value(summary.iterations_max) : json->null();
  json->key("contraction_max");
  figure(summary.contraction_max);
  json->key("residual_max");
  figure(summary.residual_max);
  json->key("error_bound").value(summary.error_bound);
  write_uniqueness(json, summary.uniqueness, summary.uniqueness_reason);
  json->key("several").value(summary.several);
  json->key("first_several").value(summary.first_several);
  write_method(json, summary.method_used);
  json->end_object();
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
    text += fmt::format(", {} iterations ({})", report.iterations, name_of(report.method_used));
  return text + fmt::format(", uniqueness {}", describe_uniqueness(report.uniqueness, report.uniqueness_reason));
}

std::string describe_friction(const FrictionSummary& summary) {
  if (summary.solves == 0) return "no iterations";
  return fmt::format("{:.3g} iterations an instant, {} at most ({}), contraction {}, uniqueness {}",
                     summary.iterations_mean, summary.iterations_max, name_of(summary.method_used),
                     in_words(summary.contraction_max, "{:.2g}"),
                     describe_uniqueness(summary.uniqueness, summary.uniqueness_reason));
}

std::string describe_several(const FrictionSummary& summary) {
  if (summary.several == 0) return "";
  return fmt::format(
      "friction: several accelerations obeyed the law at {} instants, at t = {} s first; the motion goes on with those "
      "nearest to the step before",
      summary.several, summary.first_several);
}

}  // namespace tanor::report
