#include "report/friction_parts.hpp"

#include <fmt/format.h>

#include <tanor/enum_names.hpp>

#include "base/text.hpp"
#include "report/words.hpp"

namespace tanor::report {
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

/// Returns null if no friction depends on reactions, because nothing was iterated then.
Json name_method(FrictionMethod method) {
  return method == FrictionMethod::Auto ? Json() : Json(name_of(method));
}

Json name_uniqueness(Uniqueness uniqueness) {
  return uniqueness == Uniqueness::NotAsked ? Json() : Json(name_of(uniqueness));
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
  const FrictionReport& found = report ? *report : FrictionReport();
  const bool is_iterated = report && found.method_used != FrictionMethod::Auto;
  const auto if_iterated = [&](auto number) { return is_iterated ? Json(number) : Json(); };
  return {{"contacts", report ? Json(found.contacts) : Json()},
          {"sticking", report ? Json(found.sticking) : Json()},
          {"sticking_is_indeterminate", found.contacts > 0 ? Json(found.sticking_is_indeterminate) : Json()},
          {"iterations", if_iterated(found.iterations)},
          {"contraction", if_iterated(found.contraction)},
          {"residual", if_iterated(found.residual)},
          {"error_bound", found.error_bound},
          {"uniqueness", name_uniqueness(found.uniqueness)},
          {"uniqueness_reason", json_or_null(found.uniqueness_reason)},
          {"method_used", name_method(found.method_used)}};
}

Json describe_friction_summary(std::size_t contacts, const FrictionSummary& summary) {
  const auto if_iterated = [&](auto number) { return summary.solves > 0 ? Json(number) : Json(); };
  return {{"contacts", contacts},
          {"solves", summary.solves},
          {"iterations_mean", if_iterated(summary.iterations_mean)},
          {"iterations_max", if_iterated(summary.iterations_max)},
          {"contraction_max", if_iterated(summary.contraction_max)},
          {"residual_max", if_iterated(summary.residual_max)},
          {"error_bound", summary.error_bound},
          {"uniqueness", name_uniqueness(summary.uniqueness)},
          {"uniqueness_reason", json_or_null(summary.uniqueness_reason)},
          {"several", summary.several},
          {"first_several", summary.first_several},
          {"method_used", name_method(summary.method_used)}};
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
      summary.several, text(summary.first_several));
}

}  // namespace tanor::report
